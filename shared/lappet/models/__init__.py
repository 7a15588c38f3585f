"""Anatomical models: parts of a body, made ready to be operated on."""

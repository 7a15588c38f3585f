"""Plates: pages of line drawings of a solved procedure, with captions, labels, arrows and measures."""

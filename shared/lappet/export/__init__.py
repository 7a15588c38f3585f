"""Solved procedures for other programs: one row of `formats.py` for each format, one module for each way of writing."""

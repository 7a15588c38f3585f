"""Lessons of several procedures: chapters, hotspots and questions, from a plan in TOML."""

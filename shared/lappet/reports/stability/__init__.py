"""Stability on stiff and extreme cases."""

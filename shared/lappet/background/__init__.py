"""Solving in the background: a process of its own compiles and solves, so that a window stays responsive."""

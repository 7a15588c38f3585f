"""Solving a program, the frame store and the estimate of the error."""

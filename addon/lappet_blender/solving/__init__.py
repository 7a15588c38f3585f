"""Solving a scene's procedure in the background, and the frames that there are."""

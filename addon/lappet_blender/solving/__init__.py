"""Solving from Blender: the plan of each scene's procedure, its frames as they come, and what is shown at a frame."""

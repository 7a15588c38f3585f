"""Solving from Blender: the manifest of each scene's procedure, its frames as they come, and the one that is shown."""

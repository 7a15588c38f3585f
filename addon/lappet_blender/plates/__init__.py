"""Plates in Blender: the panel, their preview in the viewport, and what is written by an installed `lappet`."""

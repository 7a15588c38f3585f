"""Lappet in Blender: figures of solved procedures. The only package of Lappet that imports bpy.

`python -m lappet_blender.figure` draws pictures from a skin cache without a window; `lappet render` starts it.
"""

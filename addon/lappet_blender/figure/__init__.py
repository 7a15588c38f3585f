"""Pictures of solved procedures without a window: `python -m lappet_blender.figure` draws a skin cache."""

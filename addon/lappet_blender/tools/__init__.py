"""The tools of the toolbar: drawing on the skin, picking and dragging what was placed."""

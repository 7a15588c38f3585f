"""The solved skin in the scene: one mesh per epoch, positions set for each frame, materials, thread and steel."""

"""Tissue from meshes and patches, and where points lie on its skin."""

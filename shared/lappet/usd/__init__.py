"""Procedures as USD files; the only importer of pxr."""

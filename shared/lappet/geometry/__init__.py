"""Curves, triangle surfaces and solids, without knowledge of procedures' meaning."""

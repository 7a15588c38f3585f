"""Anatomy in the tissue: vessels and nerves through the cuts, and which layer lies where."""

"""The presets of tissue as tables and as curves beside the published ones."""

from __future__ import annotations

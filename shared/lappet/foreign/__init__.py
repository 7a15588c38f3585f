"""Files from others, read in a child process with limits on memory, time and size."""

from __future__ import annotations

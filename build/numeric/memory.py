"""Memory that is free goes back to the system: a process is as large as its largest moment."""

from __future__ import annotations

import ctypes
import gc
import sys


def give_back() -> None:
    """Let go of what refers to itself, and of what the C library keeps for later."""
    gc.collect()
    if sys.platform == "linux" and hasattr(library := ctypes.CDLL(None), "malloc_trim"):
        library.malloc_trim(0)

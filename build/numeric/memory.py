"""How the C library's memory is used: kept for the next array, given back between stages."""

from __future__ import annotations

import ctypes
import gc
import sys

TRIM, ARRAYS = -1, -3
"""M_TRIM_THRESHOLD and M_MMAP_THRESHOLD of glibc's mallopt()."""
KEPT, LARGE = 2**30, 2**25
"""Bytes that may stay free, and from which on an array gets pages of its own: the most that glibc
takes."""


def keep() -> None:
    """Keep what is freed for the next array, until it is given back: pages fresh from the system
    cost some 3 % of a diagnosis' time."""
    if sys.platform == "linux" and hasattr(library := ctypes.CDLL(None), "mallopt"):
        library.mallopt(TRIM, KEPT)
        library.mallopt(ARRAYS, LARGE)


def give_back() -> None:
    """Let go of what refers to itself, and of what the C library keeps for later."""
    gc.collect()
    if sys.platform == "linux" and hasattr(library := ctypes.CDLL(None), "malloc_trim"):
        library.malloc_trim(0)

"""Shares of counted cases with their 95 % intervals."""

from __future__ import annotations

import math


def wilson(hits: int, n: int) -> tuple[float, float]:
    """95 % interval of a share; 0 to 1 where nothing was tried."""
    if n == 0:
        return 0.0, 1.0
    z, p = 1.959964, hits / n
    middle, width = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    low, high = (middle - width) / (1 + z * z / n), (middle + width) / (1 + z * z / n)
    return max(0.0, min(low, p)), min(1.0, max(high, p))


def share(hits: int, n: int) -> str:
    """0 of 17 (95 % interval 0 to 18 %)."""
    if n == 0:
        return "no case"
    low, high = wilson(hits, n)
    return f"{hits} of {n} (95 % interval {100 * low:.0f} to {100 * high:.0f} %)"

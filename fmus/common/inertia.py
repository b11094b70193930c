"""The inertia matrix of a body from its six entries."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def inertia_rows(six: Sequence[Any]) -> list[list[Any]]:
    """Rows (3, 3) of the symmetric matrix of xx, yy, zz, xy, xz, yz; numbers or SX."""
    xx, yy, zz, xy, xz, yz = six
    return [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]

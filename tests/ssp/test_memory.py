"""A log that does not fit is refused with what would fit."""

from __future__ import annotations

import pytest

from flexhex.fmus.common.errors import UsageError
from flexhex.ssp import memory


def test_log_must_fit_into_the_free_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """100 values every base step and 10 every 120: 1 s of 4000 steps is 3.20 MB."""
    sizes, base = {1: 100, 120: 10}, 0.00025
    needed = 8 * (100 * 4001 + 10 * (4000 // 120 + 1))
    monkeypatch.setattr(memory, "free_memory", lambda: round(needed / memory.SHARE) + 1)
    memory.check_memory(sizes, 4000, base)
    with pytest.raises(UsageError, match=r"^a log of 2 s takes .* GB .*: run at most 1 s, or log"):
        memory.check_memory(sizes, 8000, base)


def test_free_memory_is_known_here() -> None:
    assert 2**20 < memory.free_memory() < 2**50

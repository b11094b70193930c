"""What a gap says beside its figures: much that is slow, held-out runs unlike the others."""

from __future__ import annotations

import numpy as np

from flexhex.diagnosis.gaps import slow, unlike
from flexhex.diagnosis.verdict import Gap

FLOOR = np.array([0.1, 0.1])


def gap(repeats: float = 0.0, held: float | None = None) -> Gap:
    """Two axes with a torque of 10 N m; what repeats of the first, and is left of held-out runs."""
    torque, left = np.full(2, 10.0), np.full(2, 0.2)
    repeat = np.array([repeats, 0.0])
    locked = {} if held is None else {"after": np.array([held, 0.2])}
    return Gap(("N m", "N m"), torque, left, left, left, FLOOR, repeat, repeat, locked)


def test_offset_of_whole_runs_is_told_where_it_is_more_than_noise() -> None:
    (text,) = slow(gap(repeats=0.5), {0: 0.3, 1: 0.0})
    assert text.startswith("axis 1: an offset or slope of whole runs is left, 0.4 N m")
    assert not slow(gap(repeats=0.5), {0: 0.5, 1: 0.0}), "all of it is found by the search"
    assert not slow(gap(repeats=0.15), {0: 0.0, 1: 0.0}), "noise"
    assert not slow(gap(repeats=np.nan), {0: 0.0, 1: 0.0}), "no repeats"


def test_held_out_runs_that_hold_more_are_told() -> None:
    (text,) = unlike(gap(held=0.6))
    assert text.startswith("axis 1: 0.6 N m is left of the held-out runs, 0.2 N m of the others")
    assert not unlike(gap(held=0.3))
    assert not unlike(gap())

"""What a residual says beside its figures: offsets of whole runs that no search looks at, and what
held-out runs alone show."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis import residuals
from flexhex.diagnosis.residuals import levelled, slow, unseen
from flexhex.diagnosis.result.verdict import Residual

NON_REPEATABLE = np.array([0.1, 0.1])


def residual(repeats: float) -> Residual:
    """Two axes with a torque of 10 N m, and what repeats of the first."""
    torque, left = np.full(2, 10.0), np.full(2, 0.2)
    repeatable = np.array([repeats, 0.0])
    return Residual(
        ("N m", "N m"), torque, left, left, left, NON_REPEATABLE, repeatable, repeatable
    )


def test_offset_of_whole_runs_is_reported_where_it_is_more_than_noise() -> None:
    (text,) = slow(residual(repeats=0.5), np.array([0.3, 0.0]))
    assert text.startswith("axis 1: an offset or slope of whole runs is left, 0.4 N m")
    assert not slow(residual(repeats=0.5), np.array([0.5, 0.0])), "no run has an offset"
    assert not slow(residual(repeats=0.08), np.zeros(2)), "noise"
    assert not slow(residual(repeats=np.nan), np.zeros(2)), "no repeats"


def test_offsets_of_several_axes_are_one_sentence() -> None:
    both = residual(repeats=0.5)
    both.repeatable_after[1] = 0.3
    (text,) = slow(both, np.array([0.3, 0.0]))
    what = "offsets or slopes of whole runs are left, 0.4 N m, 0.3 N m:"
    assert text.startswith(f"axes 1 and 2: {what}")


def test_what_is_left_beside_offsets_has_no_straight_line(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the rows that count: a fast wave stays, an offset and a slope go, whatever others hold."""
    monkeypatch.setattr(residuals, "repeat_rms", lambda model, runs: (runs, None))
    count, rows = 400, np.arange(400)
    kept, wave = rows > 50, np.sin(rows[:, None] * [0.7, 1.1])
    left = wave + 3.0 + 0.01 * rows[:, None] + 100.0 * (rows < 40)[:, None]
    block = SimpleNamespace(moves=np.ones((count, 2), dtype=bool))
    model = SimpleNamespace(blocks=[block], kept=[kept])
    side: Any = SimpleNamespace(
        fit=SimpleNamespace(bench=SimpleNamespace(model=model), residual=[left])
    )
    (run,) = levelled(side)
    np.testing.assert_allclose(run[kept], wave[kept], atol=0.05)


def test_what_held_out_runs_alone_show_is_reported() -> None:
    plain = residual(repeats=0.02)
    judged = {
        "torque": plain.torque,
        "after": np.array([0.5, 0.1]),
        "non_repeatable": np.full(2, 0.1),
    }
    (text,) = unseen(replace(plain, held_out=judged), [])
    assert text.startswith("axis 1: the held-out runs leave 0.49 N m that repeats")
    assert not unseen(replace(plain, held_out=judged), [0]), "it is said already"
    assert not unseen(replace(residual(repeats=0.6), held_out=judged), []), "the fit shows as much"
    judged["non_repeatable"] = np.array([0.4, 0.1])
    assert not unseen(replace(plain, held_out=judged), []), "noise"
    assert not unseen(plain, []), "no held-out runs"

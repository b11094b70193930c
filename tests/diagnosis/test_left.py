"""What a model leaves: what passes have in common; where they did not move alike, what is more than
their noise; and what has no name as its size is not determined."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array

from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.left import Rest, rest_of
from flexhex.diagnosis.selection.side import _without_gains

ROWS, NOISE, TORQUE = 4000, 0.1, 2.0


def left_by(residual: np.ndarray[Any, Any], alike: bool, repeats: bool = True) -> Rest:
    """Of an axis: rows of two passes, one behind the other, that a model leaves [N m]."""
    half = ROWS // 2
    swapped = np.roll(np.arange(ROWS), half)
    pairs = csr_array((np.full(ROWS, float(alike)), (np.arange(ROWS), swapped)), (ROWS, ROWS))
    pairs.eliminate_zeros()
    rows = SimpleNamespace(
        n=1,
        pairs=pairs,
        moving=[np.ones(ROWS)],
        y=[residual],
        white_y=[residual / NOISE],
        torque_rms=np.array([TORQUE]),
        level=lambda axis, values: values,
        model=SimpleNamespace(
            noise=SimpleNamespace(repeats=repeats, rms=np.array([NOISE]), chance=np.ones(1))
        ),
    )
    nothing = np.zeros(ROWS)
    moments: Any = SimpleNamespace(
        rows=rows,
        fit=lambda fold: SimpleNamespace(q=np.zeros(0)),
        torque=lambda axis, q: nothing,
        white=lambda axis, q: nothing,
    )
    return rest_of(moments)[0]


def residual(size: float, seed: int = 1) -> np.ndarray[Any, Any]:
    """A wave of this RMS [N m] in both passes, and noise of each."""
    wave = size * np.sqrt(2) * np.sin(np.linspace(0, 60, ROWS // 2))
    noise = NOISE * np.random.default_rng(seed).standard_normal(ROWS)
    return np.tile(wave, 2) + noise


@pytest.mark.parametrize("alike", [True, False])
def test_what_repeats_is_found_whether_passes_moved_alike_or_not(alike: bool) -> None:
    rest = left_by(residual(0.06), alike)
    assert rest.size == pytest.approx(0.06 / TORQUE, rel=0.1)
    assert rest.deviations > USUAL.deviations
    assert left_by(residual(0.0), alike).deviations < USUAL.deviations


def test_nothing_is_said_of_what_was_run_once() -> None:
    assert left_by(residual(0.06), False, repeats=False) == Rest(0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("settled", "said", "deviations", "found"),
    [([], [], 9.0, [0]), ([0], [], 9.0, []), ([], [0], 9.0, []), ([], [], 3.0, [])],
    ids=["lost", "another has a name", "said already", "chance"],
)
def test_effects_of_no_sure_size_leave_something_without_a_name(
    settled: list[int], said: list[int], deviations: float, found: list[int]
) -> None:
    def on(axis: int) -> Any:
        return SimpleNamespace(score=SimpleNamespace(hypothesis=SimpleNamespace(axis=axis)))

    selection: Any = SimpleNamespace(before=(Rest(0.05, deviations, 80.0),))
    remains = _without_gains(selection, [on(0)], [on(k) for k in settled], said, USUAL)
    assert list(remains) == found
    assert all(left.whole == 0.05 for left in remains.values())

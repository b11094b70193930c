"""What repeats may be the error of a coarse encoder, if that makes as much torque."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.selection.decided import verdict_of


@pytest.mark.parametrize(
    ("left", "coarse", "verdict"),
    [
        ({1: 0.5}, [0.4, 0.0], "cannot tell"),
        ({1: 0.5}, [0.04, 0.0], "unknown"),
        ({1: 0.5}, [0.0, 0.4], "unknown"),
        ({1: 0.5, 2: 0.5}, [0.4, 0.04], "unknown"),
        ({1: None}, [0.4, 0.0], "cannot tell"),
    ],
    ids=["as large", "many times more", "exact angles", "on another axis", "size not known"],
)
def test_what_is_left_may_be_the_error_of_the_angles(
    left: dict[int, float | None], coarse: list[float], verdict: str
) -> None:
    rests = [SimpleNamespace(axis=axis, rms=rms) for axis, rms in left.items() if rms]
    side: Any = SimpleNamespace(remains=[axis - 1 for axis in left], rests=rests)
    model: Any = SimpleNamespace(noise=SimpleNamespace(repeats=True))
    notes = list[str]()
    assert verdict_of(model, [side], [], [], notes, np.array(coarse)) == verdict
    assert bool(notes) == (verdict == "cannot tell")

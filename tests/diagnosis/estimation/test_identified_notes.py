"""What is said of values that no machine has, and of what noise of the angles took."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.estimation import identified
from flexhex.diagnosis.estimation.records import Errors

KNOWN = [
    Known("J[1]", "kg m2", 0.0, 1.0, "J", 0),
    Known("o[1]", "N m", 0.0, 1.0, "friction", 0),
    Known("delay", "s", 0.0, 1e-3, "delay"),
]


def estimated(off: float, deviation: float) -> Any:
    """A fit whose inertia would be so far off, and whose values noise made smaller by a tenth."""
    values = np.array([0.1, 0.5, 2e-4])
    return SimpleNamespace(
        known=KNOWN,
        values=values,
        free=values - [off, 0.0, 0.0],
        covariance=np.diag([deviation, 1e-3, 1e-5]) ** 2,
        wrong={"J[1]": (0,)},
        attenuated=np.array([0.1, 0.0, 0.1]) * values,
        model=SimpleNamespace(base=SimpleNamespace(n=1), blocks=()),
    )


@pytest.mark.parametrize(
    ("off", "deviation", "said"),
    [(0.2, 0.02, "up to 10.0 standard deviations away"), (0.2, 0.0, "more than 1000 standard")],
)
def test_notes_have_numbers_that_can_be_read(
    off: float, deviation: float, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(identified, "negative_values", lambda _: ([], []))
    errors = Errors(*(np.array([0.01]),) * 3)
    notes = identified._notes(estimated(off, deviation), errors)
    assert any(said in note for note in notes), notes
    (smaller,) = [note for note in notes if "too small" in note]
    assert "J[1] by 10.0%" in smaller
    assert "delay" not in smaller

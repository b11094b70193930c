"""Which masses of a machine may be others by themselves."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.selection.hypothesis import ChangedParameter, HeavierBody
from flexhex.diagnosis.selection.others import others


def test_mass_of_a_link_changes_with_its_moments() -> None:
    """That of what carries payloads may change alone, and that of a slide has no moments."""
    known = [
        *(Known(f"{body}.{name}", unit, 1.0, 0.1, body, None)
          for body in ("link", "tool") for name, unit in (("m", "kg"), ("mc_x", "kg m"))),
        *(Known(f"m[{i + 1}]", "kg", 1.0, 0.1, "m", i) for i in range(2)),
    ]  # fmt: skip
    base = SimpleNamespace(linear=known, payload=(2, 3))
    model: Any = SimpleNamespace(known=known, scale=np.full(6, 0.1), base=base, off=1.0)
    listed = others(model)
    alone = [one.places for one in listed if type(one) is ChangedParameter]
    assert (0,) not in alone
    assert {(1,), (2,), (3,), (4,), (5,)} <= {*alone}
    assert (0, 1) in [one.places for one in listed if isinstance(one, HeavierBody)]

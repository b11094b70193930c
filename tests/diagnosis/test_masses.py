"""Which masses of a machine may be others by themselves."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.selection.changed import ChangedParameter, HeavierBody
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


def test_body_and_its_geometry_change_by_themselves() -> None:
    """A joint that sits elsewhere is no other mass; what has no mass is a group as before."""
    units = {"m": "kg", "mc_x": "kg m", "x": "m", "yaw": "rad"}
    known = [Known(f"link.{name}", unit, 1.0, 0.1, f"link.{name}") for name, unit in units.items()]
    known += [Known(f"gravity.{axis}", "rad", 0.0, 0.1, f"gravity.{axis}") for axis in "xy"]
    base = SimpleNamespace(linear=known, payload=())
    model: Any = SimpleNamespace(known=known, scale=np.full(6, 0.1), base=base, off=1.0)
    places = {one.id: one.places for one in others(model) if type(one) is ChangedParameter}
    assert places["link"] == (0, 1)
    assert places["link (geometry)"] == (2, 3)
    assert places["gravity"] == (4, 5)

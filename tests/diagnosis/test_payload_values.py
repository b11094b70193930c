"""What is said of a payload that only the runs show."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.result.changed import payload_changes

UNITS = (("J", "kg m2"), ("g_s", "N m"))


@pytest.mark.parametrize(("deviation", "shown"), [(0.1, ["payload.J"]), (2.0, [])])
def test_payload_of_an_axis_is_given_by_what_it_surely_adds(
    deviation: float, shown: list[str]
) -> None:
    known = tuple(Known(f"payload.{n}", u, 0.0, np.inf, "payload") for n, u in UNITS)
    load = SimpleNamespace(name="payload", bit=1, known=known, on=lambda run: run.name == "a")
    model = SimpleNamespace(
        loads=(load,),
        places=lambda _: slice(0, 2),
        blocks=[SimpleNamespace(run=SimpleNamespace(name=n)) for n in "ab"],
        scale=np.ones(2),
        base=SimpleNamespace(reach=np.inf),
    )
    fit: Any = SimpleNamespace(
        bench=SimpleNamespace(model=model),
        q=np.array([1.0, 0.1]),
        covariance=np.diag([deviation, 1.0]) ** 2,
    )
    changes = payload_changes(fit)
    assert [change.parameter for change in changes] == shown
    assert all(change.runs == ("a",) for change in changes)

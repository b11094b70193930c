"""Which verdict comes of what was found, and what is left."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.selection.decided import verdict_of


@pytest.mark.parametrize(
    ("changed", "refuted", "verdict", "last"),
    [
        ([], False, "none", "before"),
        ([], True, "cannot tell", "with the parameters that these runs ask for"),
        (["J[1]"], True, "changed", "before"),
    ],
    ids=["nothing", "parameters that must not be others", "others that may"],
)
def test_file_that_is_wrong_in_no_known_way_lacks_something(
    changed: list[Any], refuted: bool, verdict: str, last: str
) -> None:
    """A verdict `none` would say that the machine file is right."""
    notes = ["before"]
    side: Any = SimpleNamespace(remains=[], rests=[], unconfirmed=False, refuted=refuted)
    model: Any = SimpleNamespace(noise=SimpleNamespace(repeats=True))
    assert verdict_of(model, [side], [], changed, notes, np.zeros(1)) == verdict
    assert notes[-1].startswith(last)

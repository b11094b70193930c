"""Which verdict comes of what was found, and what is left."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.selection.decided import verdict_of
from flexhex.diagnosis.selection.unrefuted import OTHERS


@pytest.mark.parametrize(
    ("changed", "notes", "verdict", "last"),
    [
        ([], [], "none", ""),
        ([], [OTHERS, "more"], "cannot tell", OTHERS),
        (["J[1]"], [OTHERS, "more"], "changed", "more"),
    ],
    ids=["nothing", "parameters that must not be others", "others that may"],
)
def test_file_that_is_wrong_in_no_known_way_lacks_something(
    changed: list[Any], notes: list[str], verdict: str, last: str
) -> None:
    """A verdict `none` would say that the machine file is right."""
    side: Any = SimpleNamespace(remains=[], rests=[], unconfirmed=False)
    model: Any = SimpleNamespace(noise=SimpleNamespace(repeats=True))
    assert verdict_of(model, [side], [], changed, notes, np.zeros(1)) == verdict
    assert "".join(notes[-1:]).startswith(last)

"""`flexhex diagnose --isolability`: table, page and JSON of a small matrix."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexhex.diagnose.isolability import verdict
from flexhex.diagnosis.planning.isolability import Isolability


def matrix() -> Isolability:
    """Three effects: the first two alike, the last never found."""
    share = np.array([[1.0, 0.95, 0.1], [0.4, 1.0, 0.2], [0.1, 0.2, 1.0]])
    ids = ("coulomb_friction", "stribeck_friction", "gravity_tilt")
    return Isolability(ids, ((3,), (3,), ()), share, np.array([0.002, 0.0031, np.nan]))


def test_isolability_is_shown_and_written(
    call: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    seen: list[Any] = []

    def isolability(*words: Any) -> Isolability:
        seen.extend(words)
        return matrix()

    monkeypatch.setattr(
        "flexhex.diagnosis.planning.isolability.isolability", isolability, raising=False
    )
    done = call("a.csv", "b.csv", "--isolability")
    assert done.exit_code == 0, done.output
    assert [path.name for path in seen[0]] == ["a.csv", "b.csv"]
    assert "0 of 3 effects could be identified alone" in done.stdout
    page = (tmp_path / "isolability.html").read_text(encoding="utf-8")
    assert 'id="matrix"' in page
    data = json.loads(call("a.csv", "--isolability", "--json").stdout)
    assert data["share"] == matrix().share.tolist()
    assert data["smallest"]["values"] == [0.002, 0.0031, None]


@pytest.mark.parametrize(("n", "shown"), [(1, False), (3, True)])
def test_axis_that_is_shown_is_said_where_there_are_others(n: int, shown: bool) -> None:
    said = verdict(replace(matrix(), axis=3, n=n))
    assert said.endswith("Shown for axis 3, which moves most of the 3 axes.") is shown


def test_effects_are_alike_when_either_takes_over_the_other() -> None:
    isolability = matrix()
    assert (isolability.rivals(0), isolability.rivals(1), isolability.rivals(2)) == ([1], [0], [])
    assert isolability.rivals(0, alike=0.96) == []

"""What locked runs speak against is withdrawn: that effect alone, and it is said."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import flexhex.diagnosis.sides as sides
import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis.single import write

Array = NDArray[np.float64]
TWICE = ((1, 1), (1, 2), (2, 1), (2, 2))


class Locked:
    """Stands for `flexhex.diagnosis.answer.Elsewhere`: mean squares by the ids of the parts."""

    def __init__(self, left: dict[str, tuple[float, float]]) -> None:
        self.left = left

    def squares(self, parts: Sequence[Any]) -> Array:
        return np.array(self.left["".join(sorted(part.id for part in parts))])


def withdrawn(
    monkeypatch: pytest.MonkeyPatch,
    parts: dict[str, int | None],
    left: dict[str, tuple[float, float]],
) -> tuple[str, list[str]]:
    """Ids that are kept, and what is said; parts: ids with their axes."""
    monkeypatch.setattr(sides, "only", lambda held, kept: SimpleNamespace(parts=kept))
    listed = [SimpleNamespace(id=id, axis=axis) for id, axis in parts.items()]
    notes: list[str] = []
    held: Any = SimpleNamespace(parts=listed)
    kept = sides.not_worse(held, Locked(left), notes)  # type: ignore[arg-type]
    return "".join(part.id for part in kept.parts), notes


def test_effect_that_helps_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    left = {"": (4.0, 1.0), "a": (1.0, 1.0)}
    assert withdrawn(monkeypatch, {"a": 0}, left) == ("a", [])


def test_effect_that_harms_goes_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    left = {"ab": (1.5, 1.0), "a": (1.0, 1.0), "b": (5.0, 1.0), "": (4.0, 1.0)}
    kept, notes = withdrawn(monkeypatch, {"a": 0, "b": 0}, left)
    assert kept == "a"
    assert notes == ["b on axis 1 was withdrawn: it increases the residual of the held-out runs"]


def test_effect_is_judged_on_its_own_axis(monkeypatch: pytest.MonkeyPatch) -> None:
    """It helps axis 2 by more than it harms axis 1, on which it acts."""
    left = {"a": (1.1, 1.0), "": (1.0, 9.0)}
    assert withdrawn(monkeypatch, {"a": 0}, left)[0] == ""
    assert withdrawn(monkeypatch, {"a": 1}, left)[0] == "a"
    assert withdrawn(monkeypatch, {"a": None}, left)[0] == "a"


def test_effects_that_harm_go_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two that harm together: without the worse one the other may help."""
    left = {"ab": (3.0, 1.0), "a": (1.0, 1.0), "b": (2.5, 1.0), "": (2.0, 1.0)}
    assert withdrawn(monkeypatch, {"a": 0, "b": 0}, left)[0] == "a"


@pytest.mark.slow
def test_friction_that_the_locked_runs_have_not_is_withdrawn(tmp_path: Path) -> None:
    paths = [write(tmp_path / f"{s}_{k}.csv", s, k, 0.12) for s, k in TWICE]
    options = Options(base="axis")
    said = {}
    for friction in (0.12, 0.0):
        locked = [write(tmp_path / f"locked {friction}.csv", 3, 1, friction)]
        said[friction] = diagnose(paths, locked, options=options)
    assert said[0.12].effects != ()
    assert not any("withdrawn" in note for note in said[0.12].notes)
    assert said[0.0].effects == ()
    assert any(
        "was withdrawn: it increases the residual of the held-out runs" in n
        for n in said[0.0].notes
    )
    # what was found before is still there, so that nothing is no answer
    assert said[0.0].verdict == "unknown"
    np.testing.assert_array_equal(said[0.0].gap.locked["after"], said[0.0].gap.locked["before"])

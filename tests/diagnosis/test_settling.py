"""The search begins anew beside the base model that its own answer leaves, until that stays."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis import workflow

WIDTHS = [8e-3, 12e-3, 14e-3, 15e-3, 15e-3]
"""Of the base model after each search: beside a friction it finds back to its own."""


def searched(
    monkeypatch: pytest.MonkeyPatch, widths: list[float], named: bool = True
) -> list[float]:
    """Widths beside which was searched; named: an effect was found."""
    made = [
        SimpleNamespace(fitted=SimpleNamespace(widths=np.array([w]), delay=0.0, late=1.0))
        for w in widths
    ]
    asked: list[Any] = []

    def side(bench: Any, *more: Any) -> Any:
        asked.append(bench.made)
        held = SimpleNamespace(bench=bench)
        return SimpleNamespace(held=held, accepted=[held] if named else [])

    bench = lambda made, known: SimpleNamespace(made=made, forget=lambda: None)  # noqa: E731
    monkeypatch.setattr(workflow, "Bench", bench)
    monkeypatch.setattr(workflow, "selected", side)
    monkeypatch.setattr(workflow, "before_of", lambda side: side.held.bench.made)
    monkeypatch.setattr(workflow, "beside", lambda held: made[made.index(held.bench.made) + 1])
    start: Any = made[0]
    before, last = workflow._mechanism(start, [], [], lambda text: None)
    assert before is asked[0]  # type: ignore[comparison-overlap]
    assert last.held.bench.made is asked[-1]
    return [float(m.fitted.widths[0]) for m in asked]


def test_search_goes_on_while_a_width_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    assert searched(monkeypatch, [8e-3, 15e-3, 15.1e-3, 1.0]) == [8e-3, 15e-3]


def test_width_that_stays_asks_for_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    assert searched(monkeypatch, [15e-3, 15.5e-3, 1.0]) == [15e-3]


def test_search_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    assert searched(monkeypatch, WIDTHS) == WIDTHS[: workflow.SEARCHES]


def test_without_an_effect_there_is_nothing_to_search_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert searched(monkeypatch, WIDTHS, named=False) == WIDTHS[:1]

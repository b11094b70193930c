"""Criteria halved and doubled: only the one that is meant, and nothing stays changed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.jointfit import guard
from flexhex.diagnosis.selection.criteria import USUAL, Criteria
from flexhex.diagnosis.selection.moments import Term
from results.tables import sensitivity as table
from studies import sensitivity
from studies.families import FAMILIES
from studies.mujoco import engines
from studies.remembered import key_of_scores, remembered
from studies.sensitivity import Variation, changed, summary, value_of, variations
from studies.takers import takers


def test_every_criterion_is_varied_and_put_back() -> None:
    listed = variations()
    assert {v.name for v in listed} == set(vars(USUAL))
    for variation in (*listed, *variations(True)):
        before = sensitivity.value_of(variation.module, variation.name)
        with changed(variation):
            other = sensitivity.value_of(variation.module, variation.name)
            whole = round(before * variation.factor) if isinstance(before, int) else None
            assert other == (whole or before * variation.factor)
        assert sensitivity.value_of(variation.module, variation.name) == before
    assert Criteria() == USUAL


def test_engine_is_asked_with_each_value(monkeypatch: pytest.MonkeyPatch) -> None:
    def answer(*files: object) -> dict[str, Any]:
        verdict = f"{USUAL.odds:g} {guard.POOR:g}"
        return {"verdict": verdict, "effects": [], "changed": [], "findings": [], "residual": {}}

    monkeypatch.setattr(engines, "today", answer)
    answers = sensitivity.varied((), (), Path())
    said = {name: answer["verdict"] for name, answer in answers.items()}
    assert (said["odds x 0.5"], said["odds x 2"]) == ("10 0.5", "40 0.5")
    assert {said[name] for name in said if "odds" not in name} == {"20 0.5"}
    further = sensitivity.varied_elsewhere((), (), Path())
    assert further["jointfit.guard.POOR x 2"]["verdict"] == "20 1"


def flat(value: Any) -> Iterator[Any]:
    """All that an answer holds, with its keys."""
    if isinstance(value, dict):
        value = [item for pair in value.items() for item in pair]
    if isinstance(value, (list, tuple)):
        for item in value:
            yield from flat(item)
    else:
        yield value


def test_what_is_remembered_does_not_change_the_answer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An effect is found in two searches; with a higher bar it is not, from the same memory.

    Columns that are kept lose digits: single precision is enough for them.
    """
    monkeypatch.setattr("studies.mujoco.draw.MOST_STEPS", 4000)
    case = FAMILIES["mujoco"](256, tmp_path / "logs", tmp_path / "truth", None)
    files = case.paths, case.test_paths, case.machine_file
    variation = Variation("", "smallest_effect", 1000.0)

    def strictly() -> dict[str, Any]:
        with changed(variation):
            return engines.today(*files)

    plain = engines.today(*files)
    with remembered():
        answers = [(engines.today(*files), strictly()) for _ in range(2)]
    strict = strictly()
    assert plain["effects"]
    assert not strict["effects"]
    for answer in answers:
        assert [*flat(answer)] == [
            pytest.approx(value, rel=1e-6) if isinstance(value, float) else value
            for value in flat((plain, strict))
        ]


def test_scores_beside_other_errors_of_form_are_others() -> None:
    """Their size is a criterion."""

    def key(error: float) -> object:
        term = Term({}, {0: np.zeros(0)}, np.array([error**-2.0]))
        moments, model = SimpleNamespace(terms=(term,), tight={}), SimpleNamespace(model=None)
        return key_of_scores(moments, SimpleNamespace(bench=model), (), USUAL, (0,))

    assert key(0.05) == key(0.05)
    assert key(0.05) != key(0.1)


def test_summary_says_how_many_cases_moved() -> None:
    usual = {"outcome": "right"}
    outcomes = {"as it is": usual, "odds x 0.5": {"outcome": "wrong"}, "odds x 2": usual}
    case = {"family": "axes", "seed": 3, "outcomes": outcomes}
    result = summary([case, {"family": "axes", "seed": 4, "outcomes": {}}])
    assert result["variations"]["odds x 0.5"] == {
        "n": 1,
        "good": 0,
        "wrong": 1,
        "moved": ["axes 3: right -> wrong"],
    }
    assert result["variations"]["odds x 2"]["moved"] == []
    assert "| `odds` | 20 | 0 / 1 / 1 | 1 / 0 / 0 |" in table(result)


def test_number_is_changed_wherever_it_was_imported_to() -> None:
    homes = {(v.module, v.name) for v in variations(elsewhere=True)}
    for module, name in homes:
        own = value_of(module, name)
        found = takers(f"flexhex.diagnosis.{module}", name)
        assert all(getattr(taker, name) == own for taker in found), (module, name)
    others = takers("flexhex.diagnosis.jointfit.guard", "TOGETHER")
    assert "flexhex.diagnosis.prepare" in [taker.__name__ for taker in others]
    variation = Variation("jointfit.guard", "TOGETHER", 0.5)
    with changed(variation):
        assert len({taker.TOGETHER for taker in others}) == 1
        assert value_of("jointfit.guard", "TOGETHER") == others[-1].TOGETHER

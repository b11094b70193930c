"""The study around the scorer, with stand-ins for the diagnosis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from studies import hidden_effects
from studies.generator.draw import slots
from studies.hidden_effects import judge
from studies.score import Score
from studies.store import Store
from tests.oracles.calculus import Array
from tests.studies.test_scoring import Found, draw_of, effect, judged, said


def test_store_goes_on_where_it_stopped(tmp_path: Path) -> None:
    path = tmp_path / "study.jsonl"
    one = judged("single", "alone", ("quadratic_drag",))
    Store(path).add(("seed", 4), one)
    with path.open("a") as file:
        file.write('{"task": ["seed", 5], "see')
    again = Store(path)
    assert again.done == {("seed", 4): replace(one, notes={})}
    again.add(("machine", 1), one)
    assert set(Store(path).done) == {("seed", 4), ("machine", 1)}
    path.write_text('{"foreign": 1}\n')
    with pytest.raises(ValueError, match="jsonl:1"):
        Store(path)


def quick(monkeypatch: pytest.MonkeyPatch, seconds: float = 1.0) -> None:
    """Runs of 1 s instead of 12."""
    monkeypatch.setattr(hidden_effects, "draw", lambda seed: draw_of(seed, seconds))


def test_study_hands_over_logs_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A stand-in for the diagnosis looks around: it gets logs of all passes, the last trajectory
    apart, and no truth near them; what it says is judged."""
    quick(monkeypatch)
    seen: list[Path] = []

    def blind(paths: Sequence[Path], locked: Sequence[Path], machine: Path) -> Found:
        assert len(paths) == 4
        assert len(locked) == 2
        near = [p for path in paths for p in path.parent.rglob("*")]
        assert {p.suffix for p in near} <= {".h5", ".csv"}
        seen.extend(paths)
        return said("none")

    listed = [row[0] for row in slots()]
    expected = {"nothing": "silent", "single": "missed", "outside": "unnoticed"}
    expected["changed"] = "missed"
    for category, outcome in expected.items():
        found = judge(("seed", listed.index(category)), blind, keep=tmp_path)
        assert (found.category, found.outcome) == (category, outcome)
    assert not any(path.exists() for path in seen)
    assert len(list((tmp_path / "sealed").iterdir())) == 4


def test_effect_that_is_named_is_held_against_the_same_runs_without_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A stand-in that names the effect is given a second case: the same motion and noise, and the
    torques differ by what is hidden alone."""
    quick(monkeypatch, 3.0)
    given: list[Array] = []

    def knowing(paths: Sequence[Path], locked: Sequence[Path], machine: Path) -> Found:
        with h5py.File(sorted(paths)[0]) as file:
            given.append(np.asarray(file["tau_meas"]))
        gap = {"before": 0.05 / len(given), "after": 0.014, "floor": 0.01}
        return said("named", effect("cogging_harmonic", range(1, 7))) | {"gap": gap}

    number = slots().index(("single", "cogging_harmonic", 0.03, False))
    found = judge(("seed", number), knowing)
    hidden, bare = given
    (axis,) = (k for h in hidden_effects.case_of(("seed", number)).hidden for k in h.axes)
    shares = np.std(hidden - bare, axis=0) / np.std(bare, axis=0)
    assert shares[axis] > 0.05
    assert np.delete(shares, axis).max() < 0.02, "quantisation alone"
    assert found.truth == ("cogging_harmonic",)
    assert found.closed_effect == pytest.approx((0.05 - 0.014) / 0.025)


def test_study_goes_on_after_a_failed_case(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(task: object) -> Score:
        raise RuntimeError("no such thing")

    monkeypatch.setattr(hidden_effects, "judge", broken)
    assert "no such thing" in str(hidden_effects.attempt(("seed", 1)))

"""Adding what was found: how a diagnosis and the rebuilt model become one answer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexhex.diagnose.apply import add, with_rebuilt
from flexhex.diagnose.loops import Tracking
from flexhex.diagnose.rebuild import Rebuilt, Residuals
from flexhex.diagnosis.logs import Options
from flexhex.simulation.builder import Builder
from tests.conftest import MACHINE_FILE
from tests.flexhex.diagnoses import BASIC, CHANGED, PAIR

HEAD = 'extends = "tflex.toml"\ndiagnosed = true\n'


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A machine file to which an effect was added."""
    written = tmp_path / "machine.toml"
    written.write_text(HEAD + '[[effects]]\nid = "coulomb_friction"\n', encoding="utf-8")
    return written


def rebuilt(path: Path, withdrawn: tuple[str, ...] = (), left_out: tuple[str, ...] = ()) -> Rebuilt:
    """A model that follows one held-out run better, in a loop that is better too."""
    residuals = {"c.csv": Residuals(np.full(6, 0.05), np.full(6, 0.01))}
    loops = {"model": (Tracking(26.4, 0.02), Tracking(8.5, 0.01))}
    notes = tuple(f"{name} was withdrawn" for name in withdrawn)
    builder = Builder(MACHINE_FILE, Path("o"))
    return Rebuilt(builder, path, left_out, withdrawn, residuals, loops, notes)


def test_rebuilt_model_is_the_answers_machine(path: Path) -> None:
    done = with_rebuilt(BASIC, rebuilt(path, left_out=("time_delay: too long",)))
    assert (done.machine, done.verdict) == (str(path), "named")
    assert done.effects == BASIC.effects
    assert done.shown == rebuilt(path, left_out=("time_delay: too long",)).data()
    assert done.notes == (*BASIC.notes, "not added: time_delay: too long")


def test_withdrawn_effect_is_named_no_longer(path: Path) -> None:
    done = with_rebuilt(replace(PAIR, changed=()), rebuilt(path, ("cogging_harmonic",)))
    assert [effect.id for effect in done.effects] == ["coulomb_friction"]
    assert (done.verdict, done.machine) == ("named", str(path))
    assert "cogging_harmonic was withdrawn" in done.notes


def test_nothing_is_named_when_every_effect_is_withdrawn(path: Path) -> None:
    path.write_text(HEAD, encoding="utf-8")
    done = with_rebuilt(BASIC, rebuilt(path, ("coulomb_friction",)))
    assert (done.verdict, done.effects, done.machine) == ("unknown", (), None)
    assert done.notes[-1].startswith("nothing was added")


def test_changed_values_alone_make_a_machine(path: Path) -> None:
    assert with_rebuilt(CHANGED, rebuilt(path)).machine == str(path)


def test_values_that_a_machine_file_has_no_place_for_make_none(path: Path) -> None:
    """Else a residual that is as it was would end with exit code 0."""
    path.write_text(HEAD, encoding="utf-8")
    done = with_rebuilt(CHANGED, rebuilt(path, left_out=("lower[5].J_xx: no place for it",)))
    assert (done.verdict, done.machine, done.shown) == ("changed", None, {})
    assert done.notes[-2:] == (
        "not added: lower[5].J_xx: no place for it",
        "nothing was added: the machine file has no place for it, or it was withdrawn",
    )


def test_runs_and_options_arrive(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []

    def fake(*words: Any, **more: Any) -> Rebuilt:
        seen.extend([*words, more["options"]])
        return rebuilt(path)

    monkeypatch.setattr("flexhex.diagnose.apply.rebuild", fake)
    logs, runs, held_out = Options(3.0), [Path("a")], [Path("b")]
    add(BASIC, MACHINE_FILE, Path("o"), runs, held_out, logs)
    assert seen == [MACHINE_FILE, BASIC, Path("o"), runs, held_out, logs]

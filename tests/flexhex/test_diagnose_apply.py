"""Adding what was found: how a diagnosis and the rebuilt model become one answer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from diagnosis.logs import Options
from flexhex.build import Builder
from flexhex.diagnose_apply import add, with_rebuilt
from flexhex.rebuild import Gaps, Rebuilt, Tracking
from tests.conftest import MACHINE_FILE
from tests.flexhex.diagnoses import BASIC, CHANGED, PAIR


def rebuilt(withdrawn: tuple[str, ...] = (), left_out: tuple[str, ...] = ()) -> Rebuilt:
    """A model that follows one locked run better, in a loop that is better too."""
    gaps = {"c.csv": Gaps(np.full(6, 0.05), np.full(6, 0.01))}
    loops = {"model": (Tracking(26.4, 0.02), Tracking(8.5, 0.01))}
    notes = tuple(f"{name} was withdrawn" for name in withdrawn)
    builder, path = Builder(MACHINE_FILE, Path("o")), Path("o/machine.toml")
    return Rebuilt(builder, path, left_out, withdrawn, gaps, loops, notes)


def test_rebuilt_model_is_the_answers_machine() -> None:
    done = with_rebuilt(BASIC, rebuilt(left_out=("time_delay: too long",)))
    assert (done.machine, done.verdict) == ("o/machine.toml", "named")
    assert done.effects == BASIC.effects
    assert done.shown == rebuilt(left_out=("time_delay: too long",)).data()
    assert done.notes == (*BASIC.notes, "not added: time_delay: too long")


def test_withdrawn_effect_is_named_no_longer() -> None:
    done = with_rebuilt(replace(PAIR, changed=()), rebuilt(("cogging_harmonic",)))
    assert [effect.id for effect in done.effects] == ["coulomb_friction"]
    assert (done.verdict, done.machine) == ("named", "o/machine.toml")
    assert "cogging_harmonic was withdrawn" in done.notes


def test_nothing_is_named_when_every_effect_is_withdrawn() -> None:
    done = with_rebuilt(BASIC, rebuilt(("coulomb_friction",)))
    assert (done.verdict, done.effects, done.machine) == ("unknown", (), None)
    assert done.notes[-1].startswith("nothing was added")


def test_changed_values_alone_make_a_machine() -> None:
    assert with_rebuilt(CHANGED, rebuilt()).machine == "o/machine.toml"


def test_runs_and_options_arrive(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []

    def fake(*words: Any, **more: Any) -> Rebuilt:
        seen.extend([*words, more["options"]])
        return rebuilt()

    monkeypatch.setattr("flexhex.diagnose_apply.rebuild", fake)
    logs, runs, locked = Options(3.0), [Path("a")], [Path("b")]
    add(BASIC, MACHINE_FILE, Path("o"), runs, locked, logs)
    assert seen == [MACHINE_FILE, BASIC, Path("o"), runs, locked, logs]

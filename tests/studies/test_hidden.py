"""A sample of the study: effects hidden by the foreign generator, diagnosed from the logs.

A few cases of each category, minutes each, so only gross failures show; tests/diagnosis has small
ones. The figures with their intervals come from `python -m studies.hidden_effects` over some
hundred seeds.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from studies.families import FAMILIES
from studies.generator.draw import ROUND, slots
from studies.hidden_effects import Task, case, outcome_of
from studies.honest import Outcome
from studies.honest_values import FAINT, names_of
from studies.mujoco import engines

pytestmark = pytest.mark.slow
SAMPLE_FROM = 3 * ROUND
"""First seed of the round that the sample is taken from."""
HEIGHT = {"coulomb_friction": "F_c", "second_hysteresis": "c_2"}
"""The gain of what is Dahl's bristle, under either name."""


def seed_of(category: str, id: str = "", size: float | None = None) -> int:
    """The first seed of that round with such a case."""
    for k, row in enumerate(slots()):
        if row[0] == category and id in ("", row[1]) and size in (None, row[2]):
            return SAMPLE_FROM + k
    raise LookupError(f"{category} {id} {size}: not in a round")


def verdict(category: str, id: str = "", size: float | None = None) -> Outcome:
    """Generated, diagnosed and judged."""
    return outcome_of(case(Task("generator", seed_of(category, id, size))))


def test_nothing_hidden_names_nothing() -> None:
    outcome = verdict("nothing")
    assert outcome.outcome != "false_alarm", outcome


@pytest.mark.parametrize("id", ["cogging_harmonic", "torque_ripple", "drive_lag"])
def test_large_effect_is_found(id: str) -> None:
    """3 % of torque RMS, of which far more than the least share is observable."""
    outcome = verdict("single", id, 0.03)
    assert outcome.observable[0] > FAINT, "the case does not test what it says"
    assert outcome.outcome in ("right", "ambiguous"), outcome


def test_friction_does_not_bend_the_hysteresis_of_the_model(tmp_path: Path) -> None:
    """Fitted without the friction the model's hysteresis is half as wide as it should be; beside
    that the friction seemed more than twice as large, and a second hysteresis stood beside it.

    A hysteresis of 2.3 mrad and friction that turns over within that angle are the same column, so
    both are named, in any order.
    """
    seed = seed_of("single", "coulomb_friction", 0.03)
    files = FAMILIES["generator"](seed, tmp_path / "logs", tmp_path / "sealed", None)
    answer = engines.today(files.paths, files.test_paths, files.machine_file)
    (hidden,) = json.loads(files.sealed.read_text(encoding="utf-8"))["hidden"]
    (effect,) = answer["effects"]
    assert hidden["id"] in names_of(effect)
    assert effect["axes"] == hidden["axes"]
    assert effect["id"] in HEIGHT, "another form, whose height is another number"
    gain, rows = HEIGHT[effect["id"]], effect["parameters"].items()
    (height,) = [row["value"] for name, row in rows if gain in name]
    np.testing.assert_allclose([height], hidden["gain"], rtol=0.15)


def test_effect_outside_the_list_gets_no_name() -> None:
    outcome = verdict("outside", "limit_cycle", 0.03)
    assert outcome.outcome in ("detected", "missed", "silent"), outcome


def test_payload_is_a_changed_parameter() -> None:
    outcome = verdict("changed", "payload")
    assert outcome.outcome == "right", outcome

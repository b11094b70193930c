"""Draws of a study: the same every time, over their whole range, of what can vary."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import truth_file
from flexhex.fmus.machine.truth import Truth, load_truth
from flexhex.study.draws import DEFAULT_VARIED, OF_MODEL, VARIED, StudyPlan, draw, varied_of
from tests.conftest import MACHINE_FILE


@pytest.fixture(scope="module")
def truth() -> Truth:
    """What machine.fmu is drawn from."""
    return load_truth(truth_file(MACHINE_FILE))


def test_draw_depends_on_seed_and_number_alone(machine: Machine, truth: Truth) -> None:
    """More runs, or one more kind that varies, leave what was drawn as it was."""
    few = StudyPlan(varied=("payload", "noise"))
    every = StudyPlan(runs=99, varied=tuple(VARIED))
    one, all_kinds = draw(few, 3, machine, truth)[0], draw(every, 3, machine, truth)[0]
    assert one.items() <= all_kinds.items()
    assert draw(few, 3, machine, truth)[0] == one
    others = [draw(few, 4, machine, truth)[0], draw(StudyPlan(seed=2), 3, machine, truth)[0]]
    assert all(other["plant.seed"] != one["plant.seed"] for other in others)


def test_draws_cover_their_range(machine: Machine, truth: Truth) -> None:
    """200 uniform draws: the mean is within 4 standard deviations, 4 / sqrt(12 * 200) = 8 %."""
    plan = StudyPlan(varied=("payload", "age"), payload=3.0, age=100.0)
    drawn = [draw(plan, k, machine, truth)[1] for k in range(1, 201)]
    for name, largest in (("payload", 3.0), ("age", 100.0)):
        values = np.array([d[name] for d in drawn]) / largest
        assert 0 <= values.min() < 0.05
        assert 0.95 < values.max() <= 1
        assert values.mean() == pytest.approx(0.5, abs=0.082)


@pytest.mark.parametrize(
    ("plan", "message"),
    [
        (StudyPlan(runs=0), "--runs 0"),
        (StudyPlan(duration=-1), "--duration -1: must be above 0"),
        (StudyPlan(payload=float("nan")), "--payload nan"),
        (StudyPlan(age=0), "--age 0"),
        (StudyPlan(varied=("weather",)), "--vary 'weather': there are noise, payload"),
        (StudyPlan(varied=()), "all runs would be the same"),
    ],
)
def test_plan_that_cannot_be_is_refused(plan: StudyPlan, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        plan.check()


def test_kinds_are_read_from_a_list() -> None:
    assert varied_of(None, MACHINE_FILE) == DEFAULT_VARIED
    assert varied_of(" noise, age,noise,", MACHINE_FILE) == ("noise", "age")


def test_machine_without_truth_varies_what_its_model_has(machine: Machine, tmp_path: Path) -> None:
    """Its draws are parameters of reference alone: plant.fmu has no noise, age or drift."""
    path = Path(shutil.copyfile(MACHINE_FILE, tmp_path / "my.toml"))
    assert varied_of(None, path) == OF_MODEL
    with pytest.raises(UsageError, match=r"--vary noise,age: my\.toml has no truth file my-truth"):
        varied_of("payload,noise,age", path)
    values, _ = draw(StudyPlan(varied=OF_MODEL), 1, machine, None)
    assert {name.partition(".")[0] for name in values} == {"reference"}

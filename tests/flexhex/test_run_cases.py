"""Cases of `flexhex run`: a machine without truth is its model; files hold what commands read."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.estimation.identify import Fit
from flexhex.diagnosis.logs import read_log
from flexhex.experiments import missing
from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.output.progress import Progress
from flexhex.run.paper import (
    JUDGED,
    SAVED,
    SAVED_ACTUATORS,
    SAVED_ELSE,
    all_rows,
    chosen,
    stage_count,
    variants,
)
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import Case, fit_case, table_cases
from flexhex.simulation.runs import reduced
from flexhex.ssp.results import Group, Result, load, save
from tests.conftest import MACHINE_FILE


@pytest.fixture
def alone(tmp_path: Path) -> Builder:
    """Builder of a copy of the machine file without truth."""
    return Builder(Path(shutil.copyfile(MACHINE_FILE, tmp_path / "my.toml")), tmp_path)


@pytest.fixture
def nominal(machine: Machine) -> Fit:
    """The model's own parameters as a fit."""
    p = base_parameters(machine)
    return Fit(p, 0.1 * np.abs(p), np.zeros(machine.n_arms), 1.0, 1, ())


def test_machine_without_truth_is_its_model(alone: Builder, builder: Builder) -> None:
    """plant.fmu stands for the machine, and knows no age."""
    case = fit_case(alone.machine, 8.0)
    ours = alone.simulated(case)
    assert (ours.plant, "plant" in ours.starts) == ("plant", False)
    assert ours.name == case.name
    assert builder.simulated(case) is case


def test_variants_of_the_model_are_not_listed_twice(
    alone: Builder, builder: Builder, nominal: Fit
) -> None:
    names = [[c.name for c in variants(b, b.machine, nominal, 8.0)] for b in (alone, builder)]
    assert names[0] == ["paper-form"]
    assert names[1][1:] == ["exact-fixed", "exact-adaptive", "exact-paper-form"]


def test_missing_needs_a_truth(alone: Builder, nominal: Fit) -> None:
    with pytest.raises(UsageError, match=r"my\.toml has no truth file, .* lacks nothing"):
        missing.run(alone, nominal, Progress(), "a test", True)


def test_stages_are_counted_as_they_are_announced() -> None:
    """3 for the fit, 1 for the table, 1 for the report; the actuators have their own 4."""
    assert stage_count(chosen(None, True, True), False) == 5
    assert stage_count(chosen(None, True, True), True) == 9
    assert stage_count(chosen(None, False, False), True) == 9 + 3
    assert stage_count(chosen("repeatability", False, True), False) == 3 + 1 + 1
    assert stage_count(chosen("missing", False, True), False) == 3 + 3 + 1


def test_what_the_model_lacks_is_asked_of_a_machine_that_differs_from_it() -> None:
    assert chosen(None, False, True) == [*chosen(None, False, False), "missing"]
    assert "missing" not in chosen(None, True, True), "a quick run shows the table alone"


def test_saved_signals_are_enough_for_identify_and_compare(
    machine: Machine, tmp_path: Path
) -> None:
    rng, names = np.random.default_rng(1), ("plant.theta", "plant.tau_meas", "reference.r")
    every = {name: rng.normal(0, 1e-2, (9000, 6)) for name in (*names, *JUDGED, "plant.x_E")}
    units = {n: "N m" if "tau" in n else "rad" for n in every}
    result = Result({"a": Group(1, machine.timing.base, every, units)}, duration=9000 * 0.00025)
    path = save(reduced(result, SAVED["fit"]), tmp_path / "fit.h5")
    log = read_log(path)
    assert log.theta == pytest.approx(every["plant.theta"])
    small = load(path).groups["a"].signals
    assert set(small) == set(names)
    assert all(
        {*JUDGED, *names} <= set(SAVED[c.name]) for c in table_cases(machine, np.ones(162), 8.0)
    )


STORED = {
    "plant.tau_meas": 0.19,
    "reference.r": 0.43,
    "feedback.e": 0.66,
    "plant.theta": 0.70,
    "feedback.tau_fb": 0.83,
}
"""Share of its 8 bytes that a stored sample takes, as measured on files of a full run."""
ELSE = 135.0
"""What a full run leaves beside these files [MB]: experiments, logs for the diagnosis, FMUs."""


def megabytes(case: Case, saved: Sequence[str]) -> float:
    """Size of the file of a case, from the joint vectors that it holds and its time."""
    vectors = {name for name in saved if not name.endswith(".fault") and not name.startswith("K.")}
    samples = case.duration * 4000
    return 8e-6 * samples * (0.3 + sum(6 * STORED[name] for name in vectors))


def test_full_run_leaves_at_most_300_mb(builder: Builder, machine: Machine, nominal: Fit) -> None:
    """`--keep all` would leave ten times as much."""
    seconds = machine.reference.duration
    fit_run = fit_case(machine, seconds)
    cases = [fit_run, *all_rows(machine, nominal, seconds)]
    cases += variants(builder, machine, nominal, seconds)
    size = sum(megabytes(case, SAVED.get(case.name, SAVED_ELSE)) for case in cases)
    alone = [fit_run, *all_rows(machine, nominal, seconds)]
    size += sum(megabytes(case, SAVED_ACTUATORS.get(case.name, SAVED_ELSE)) for case in alone)
    assert 100 < size + ELSE <= 300

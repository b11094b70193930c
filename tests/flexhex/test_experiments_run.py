"""Each experiment once on a short run: what it measures, and what the report shows of it."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.estimation.identify import Fit
from flexhex.experiments import EXPERIMENTS, experiment, render
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import base_parameters, parameters
from flexhex.output.progress import Progress
from flexhex.output.tables import table
from flexhex.simulation.builder import Builder
from flexhex.simulation.metrics import rms
from tests.flexhex.experiment_results import NAMES, Results


@pytest.fixture(scope="module")
def nominal_fit(machine: Machine) -> Fit:
    """The model's own parameters in the place of fitted ones."""
    p = base_parameters(machine)
    loose = ("upper.mc_z", "lower.J_xx")
    return Fit(p, 0.1 * np.abs(p), np.zeros(machine.n_arms), 1.0, 1, loose)


@pytest.fixture(scope="module")
def results(builder: Builder, nominal_fit: Fit) -> dict[str, Any]:
    """Every experiment once, quick, as tests want it."""
    return Results(
        lambda name: EXPERIMENTS[name].run(builder, nominal_fit, Progress(), "a test", True)
    )


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", NAMES)
def test_fragment_has_a_place_for_each_plot(name: str, results: dict[str, Any]) -> None:
    html, figures = str(render(name, results[name])), EXPERIMENTS[name].figures(results[name])
    assert figures
    for place, figure in figures.items():
        assert html.count(f'id="{place}"') == 1
        drawn = [trace["y"] for trace in figure["data"]]
        assert all(np.isfinite(ys).all() and len(ys) > 10 for ys in drawn)
    assert "nan" not in html


@pytest.mark.slow
def test_places_of_all_experiments_differ(results: dict[str, Any]) -> None:
    ids = [i for name, e in EXPERIMENTS.items() for i in e.figures(results[name])]
    assert len(ids) == len(set(ids))


def test_machine_repeats_better_than_it_follows(results: dict[str, Any]) -> None:
    """The plots' deviations are the table's up to its first sample, which comes one later."""
    result = results["repeatability"]
    assert result.plain.e < result.apart.e < result.fixed.e
    left = 1e6 * result.factor * rms(result.deviation)
    assert left == pytest.approx(result.apart.e, rel=1e-4)
    assert result.e.shape == (3, *result.e_adaptive.shape)


def test_model_line_follows_the_measured_loop(results: dict[str, Any]) -> None:
    """Even the unfitted model, actuators 5 % off, explains most of cogging and hysteresis."""
    result = results["hysteresis"]
    assert result.missed < 0.3 * result.size
    assert result.width("model") == pytest.approx(result.width("measured"), rel=0.15)


def test_estimated_mass_follows_the_true_one(results: dict[str, Any]) -> None:
    """Its steps equal the payload's within 10 %; the warm motors' loss alone makes 2 %."""
    rows = EXPERIMENTS["payload"].rows(results["payload"])
    true = np.diff([row["true"] for row in rows])
    assert np.diff([row["estimated"] for row in rows]) == pytest.approx(true, rel=0.1)
    loaded = rows[3]
    assert loaded["adaptive_settled"] < 0.5 * loaded["fixed_settled"]


def test_every_parameter_has_a_row_and_what_is_not_determined_is_marked(
    results: dict[str, Any], machine: Machine, nominal_fit: Fit
) -> None:
    rows = EXPERIMENTS["parameters"].rows(results["parameters"])
    assert [row["name"] for row in rows] == [par.name for par in parameters(machine)]
    assert tuple(row["name"] for row in rows if row["loose"]) == nominal_fit.undetermined
    html = str(render("parameters", results["parameters"]))
    assert html.count('<tr class="loose">') == 2
    assert html.count("<svg") == len(rows)


def test_share_within_two_deviations_counts_parameters(results: dict[str, Any]) -> None:
    result = results["parameters"]
    exact = dataclasses.replace(result, cold=result.fit + 1.9 * result.std)
    off = dataclasses.replace(result, cold=result.fit + 2.1 * result.std)
    assert exact.within()[0] == 1.0
    assert off.within()[0] == 0.0


@pytest.mark.parametrize("name", NAMES)
def test_rows_fit_the_columns_of_the_table(name: str, results: dict[str, Any]) -> None:
    """Every value is text, a number or nothing: anything else is a TypeError."""
    chosen = experiment(name)
    assert table(chosen.title, chosen.columns, chosen.rows(results[name]))

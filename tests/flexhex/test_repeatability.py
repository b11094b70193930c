"""The non-repeatable part is what passes do not share, whatever they do share."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from flexhex.experiments.repeatability import evaluate
from flexhex.fmus.common.machine_file import load_machine
from flexhex.simulation.cases import SETTLE
from flexhex.simulation.metrics import Figures, rms
from flexhex.simulation.passes import PASSES, non_repeatable, repeatable_share
from flexhex.simulation.published import published
from flexhex.ssp.results import Group, Result
from tests.conftest import MACHINE_FILE, ROOT


def test_what_repeats_does_not_count() -> None:
    shared = np.sin(np.linspace(0, 20, 5000))[:, None] * [1.0, 50.0]
    assert non_repeatable(np.vstack([shared] * 3)).max() < 1e-12


def test_noise_counts_in_full() -> None:
    """Three passes with independent noise of 2e-6: the factor sqrt(3 / 2) makes up for the mean."""
    shared = np.cos(np.linspace(0, 9, 20000))[:, None]
    noise = np.random.default_rng(1).normal(0, 2e-6, (60000, 1))
    result = non_repeatable(np.vstack([shared] * 3) + noise)
    assert result[0] == pytest.approx(2e-6, rel=0.02)


def test_share_is_the_papers_for_the_papers_figures() -> None:
    """1 - 0.0016 / 0.0117 = 86.3 %: a ratio of RMS values, not of their squares."""
    paper = published(MACHINE_FILE)
    assert paper
    repeated, adaptive = (Figures(*paper.rows[name]) for name in ("repeatability", "adaptive"))
    assert repeatable_share(repeated, adaptive) == pytest.approx(paper.repeatable_share, abs=5e-4)
    worse = dataclasses.replace(repeated, tau_fb=adaptive.tau_fb)
    assert repeatable_share(worse, adaptive) == 0


def test_figures_and_plots_judge_the_same_samples() -> None:
    """A jump at the first judged sample alone: the figures see it as the plots do."""
    machine = load_machine(ROOT / "machines" / "tflex-actuators.toml")
    base, passes = machine.timing.base, 0.5
    count = round((SETTLE + PASSES * passes) / base) + 1
    e = np.random.default_rng(2).normal(0, 1e-6, (count, 6))
    e[: round(SETTLE / base)] = 1.0
    e[round(SETTLE / base)] = 1e-3
    signals = {"plant.theta": e, "feedback.e": e, "feedback.tau_fb": e}
    result = Result({"base": Group(1, base, signals)}, duration=base * (count - 1))
    actual = evaluate(machine, [result, result])
    # the plots' deviations, without the factor, in the figures' unit: sums of the same numbers
    assert actual.plain.e == pytest.approx(1e6 * rms(actual.deviation), rel=1e-9)
    assert actual.plain.e > 1.5

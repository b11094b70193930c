"""Beside all that is named an effect must still stand above zero, whatever a search made of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.jointfit.answer import joint
from flexhex.diagnosis.selection.choose import Accepted, effect_scores
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.firm import firm, grouped, without_name
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score
from tests.diagnosis.test_selection import RMS, chosen, names


def wide(hypotheses: Hypotheses) -> int:
    """Place of a shape of Stribeck friction that falls within a wide rate, and turns at once."""
    shapes = hypotheses.effect("stribeck_friction", 0).shapes
    return [(s["v_s"], s["v_0"]) for s in shapes].index((0.6, 0.0))


def test_effect_that_may_be_zero_beside_the_others_has_no_name(tmp_path: Path) -> None:
    """The wave alone is there; the others were scored, and are accepted here all the same."""
    selection = chosen(tmp_path, lambda q, v, a: 0.05 * RMS * np.sin(29.0 * q))
    assert names(selection) == ["cogging_harmonic"]
    hypotheses = Hypotheses(selection.bench, Rows.of(selection.bench.model))
    many = replace(USUAL, shortlist=20)
    scores = effect_scores(hypotheses.moments, hypotheses, (), many, [0])
    others = [score for score in scores if score.size < USUAL.smallest_effect]
    assert others
    accepted = [*(Accepted(s, (), 2) for s in others), *selection.accepted]
    kept, fit = firm(selection.bench, accepted, USUAL)
    assert kept == list(selection.accepted)
    assert [part.id for part in fit.parts] == ["cogging_harmonic"]
    assert fit.sure[0] > 10 * USUAL.deviations
    assert np.hypot(*fit.beta[0]) == pytest.approx(0.05 * RMS, rel=0.02)


def test_gains_count_together(tmp_path: Path) -> None:
    """A wave of a single run of known phase: its cosine is zero, its sine is sure."""
    selection = chosen(tmp_path, lambda q, v, a: 0.05 * RMS * np.sin(29.0 * q))
    _, fit = firm(selection.bench, selection.accepted, USUAL)
    (gains,), (spread,) = fit.beta, fit.deviation
    single = np.abs(gains) / spread
    assert single.min() < USUAL.deviations < single.max()
    assert fit.sure[0] == pytest.approx(np.hypot(*single), rel=0.5)


def test_gain_that_cannot_be_negative_is_not_negative_beside_the_others(tmp_path: Path) -> None:
    """A torque that helps the motion: friction with a negative gain would explain all of it."""
    selection = chosen(tmp_path, lambda q, v, a: -0.05 * RMS * np.tanh(v / 0.001))
    hypotheses = Hypotheses(selection.bench, Rows.of(selection.bench.model))
    friction = hypotheses.effect("coulomb_friction", 0)
    score = Score(friction, 100.0, np.zeros(len(hypotheses.rows.folds)), 0.05)
    alone = joint(selection.bench, grouped(selection.bench, [Accepted(score, (), 1)]))
    assert alone.beta[0][0] == pytest.approx(-0.05 * RMS, rel=0.2)
    kept, fit = firm(selection.bench, [Accepted(score, (), 1)], USUAL)
    assert not kept
    assert not fit.parts


def test_friction_without_more_of_it_at_rest_has_the_simpler_name(tmp_path: Path) -> None:
    """Less torque when slow: breakaway torque beyond the friction would be negative."""
    selection = chosen(
        tmp_path, lambda q, v, a: 0.1 * RMS * np.tanh(v / 0.001) * (1 - 0.3 * np.exp(-np.abs(v)))
    )
    hypotheses = Hypotheses(selection.bench, Rows.of(selection.bench.model))
    folds = len(hypotheses.rows.folds)
    scores = [
        Score(hypotheses.effect(name, 0), 100.0, np.zeros(folds), 0.05, shape)
        for name, shape in (("stribeck_friction", wide(hypotheses)), ("coulomb_friction", 0))
    ]
    stribeck = Accepted(scores[0], (scores[1],), 1)
    alone = joint(selection.bench, grouped(selection.bench, [stribeck]))
    assert alone.beta[0][1] < 0 < alone.beta[0][0]
    (kept,), fit = firm(selection.bench, [stribeck], USUAL, listed=scores)
    assert kept.score is scores[1]
    assert not kept.rivals
    assert [part.id for part in fit.parts] == ["coulomb_friction"]


def test_fuller_form_that_is_not_sure_remains_a_rival(tmp_path: Path) -> None:
    """A peak at rest of two standard errors: nothing says that it is there, nor that it is not."""
    selection = chosen(
        tmp_path,
        lambda q, v, a: 0.1 * RMS * np.tanh(v / 0.001) * (1 + 0.03 * np.exp(-((v / 0.2) ** 2))),
    )
    hypotheses = Hypotheses(selection.bench, Rows.of(selection.bench.model))
    effects = [hypotheses.effect(name, 0) for name in ("stribeck_friction", "coulomb_friction")]
    zeros = np.zeros(len(hypotheses.rows.folds))
    stribeck, coulomb = (Score(effect, 100.0, zeros, 0.05) for effect in effects)
    peaked = replace(stribeck, shape=[s["v_s"] for s in effects[0].shapes].index(0.2))
    accepted = [Accepted(peaked, (), 1)]
    assert 0 < joint(selection.bench, grouped(selection.bench, accepted)).further[0] < 4
    (kept,), _ = firm(selection.bench, accepted, USUAL, listed=[stribeck, coulomb])
    assert (kept.score, kept.rivals) == (coulomb, (peaked,))


def test_effect_whose_further_gains_may_be_zero_has_the_simpler_name(tmp_path: Path) -> None:
    """A fifth more friction at rest, for rates that these runs hardly have: not sure."""
    selection = chosen(
        tmp_path,
        lambda q, v, a: 0.1 * RMS * np.tanh(v / 0.001) * (1 + 0.2 * np.exp(-np.abs(v / 0.05))),
    )
    hypotheses = Hypotheses(selection.bench, Rows.of(selection.bench.model))
    folds = np.zeros(len(hypotheses.rows.folds))
    scores = [
        Score(hypotheses.effect(name, 0), 100.0, folds, 0.05, shape)
        for name, shape in (("stribeck_friction", wide(hypotheses)), ("coulomb_friction", 0))
    ]
    stribeck = Accepted(scores[0], (scores[1],), 1)
    alone = joint(selection.bench, grouped(selection.bench, [stribeck]))
    assert alone.beta[0][1] > 0
    assert alone.further[0] < USUAL.deviations < alone.sure[0]
    (kept,), _ = firm(selection.bench, [stribeck], USUAL, listed=scores)
    assert kept.score is scores[1]
    # what was to have no name gets none by another one
    unnamed, _ = firm(selection.bench, [replace(stribeck, named=False)], USUAL, listed=scores)
    assert without_name(unnamed) == {0}
    # nobody scored the simpler one: the name stays
    (kept,), fit = firm(selection.bench, [stribeck], USUAL)
    assert kept.score is scores[0]
    assert fit.further[0] < USUAL.deviations

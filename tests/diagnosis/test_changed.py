"""Base parameters that left their tolerances, on rows whose truth is known."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.jointfit.answer import Joint
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.design import Design
from flexhex.diagnosis.regression.layout import Layout
from flexhex.diagnosis.regression.regression import Regression
from flexhex.diagnosis.result.changed import changed_of
from flexhex.diagnosis.selection import search
from flexhex.diagnosis.selection.bars import Bars, passes
from flexhex.diagnosis.selection.changed import ChangedParameter, HeavierBody
from flexhex.diagnosis.selection.changes import change_scores
from flexhex.diagnosis.selection.choose import Accepted
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.heavier import heavier, moved_gain
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score
from tests.diagnosis.test_evidence import rows_of

Array = NDArray[np.float64]
COUNT, FOLDS = 1200, 3
FREED = USUAL.loose**-2.0
BARS = Bars(float(np.log(100 / USUAL.false_alarms)), float(np.log(USUAL.odds)))


def drawn(off: Array, seed: int) -> tuple[Array, Array]:
    """Columns, and a torque with noise of one, whose parameters are `off` by so many tolerances."""
    rng = np.random.default_rng(seed)
    B = 0.5 * rng.normal(size=(COUNT, len(off)))
    return B, B @ off + rng.normal(size=COUNT)


def scored(off: Array, places: tuple[int, ...], seed: int = 1) -> Score:
    """The hypothesis that these parameters changed."""
    B, y = drawn(off, seed)
    rows = rows_of(y, B, np.ones(len(off)), np.arange(COUNT) * FOLDS // COUNT)
    (score,) = change_scores(Moments(rows), [ChangedParameter("m", places, None)], USUAL)
    return score


@pytest.mark.parametrize(("tolerances", "changed"), [(1.0, False), (3.0, False), (30.0, True)])
def test_change_is_what_tolerances_make_improbable(tolerances: float, changed: bool) -> None:
    scores = scored(np.array([tolerances, 0.0, 0.0]), (0,))
    assert passes(scores, (), BARS, USUAL) == changed


def test_errors_of_the_model_are_no_change() -> None:
    """Rows that say the same nine times over count as a ninth of them."""
    B, y = drawn(np.array([12.0, 0.0]), 1)
    fold = np.arange(COUNT) * FOLDS // COUNT

    def gain(times: float) -> float:
        rows = rows_of(np.sqrt(times) * y, np.sqrt(times) * B, np.full(2, times), fold)
        rows = replace(rows, doubt=np.full(2, times))
        (score,) = change_scores(Moments(rows), [ChangedParameter("m", (0,), None)], USUAL)
        return score.gain

    assert gain(1.0) > 40
    assert gain(9.0) == pytest.approx(gain(1.0), rel=1e-6)


def test_another_parameter_is_none_that_changed() -> None:
    assert not passes(scored(np.array([30.0, 0.0, 0.0]), (1,)), (), BARS, USUAL)


def test_body_is_found_where_several_of_its_parameters_changed() -> None:
    off = np.array([20.0, -15.0, 10.0, 0.0])
    body, single = (scored(off, places) for places in ((0, 1, 2), (0,)))
    assert passes(body, (), BARS, USUAL)
    assert body.gain > single.gain


def test_each_rotor_may_have_another_inertia() -> None:
    """All together and each alone, whatever group they are in."""
    known = [Known(f"J_r[{i + 1}]", "kg m2", 0.5, 0.1, "J_r", i) for i in range(2)]
    hypotheses = Hypotheses.__new__(Hypotheses)
    base = SimpleNamespace(linear=known, payload=())
    model: Any = SimpleNamespace(known=known, scale=np.full(2, 0.1), base=base, off=1.0)
    hypotheses.rows = SimpleNamespace(model=model)  # type: ignore[assignment]
    heavier_ones = [c for c in hypotheses.changes if isinstance(c, HeavierBody)]
    assert [c.places for c in heavier_ones] == [(0, 1), (0,), (1,)]
    assert [c.direction.tolist() for c in heavier_ones[1:]] == [[0.5 / 0.1]] * 2


def test_change_waits_for_the_effects_of_all_axes(monkeypatch: pytest.MonkeyPatch) -> None:
    """An effect that explains more is found first, though its scores are not there yet."""
    rows = SimpleNamespace(n=2)
    change = Score(ChangedParameter("m", (0,), None), 50.0, np.zeros(2), 0.01)
    effect: Any = SimpleNamespace(axis=1, id="effect", extends="")
    better = Score(effect, 400.0, np.zeros(2), 0.1)
    monkeypatch.setattr(search, "parameter_scores", lambda *_: [change])
    monkeypatch.setattr(search, "payload_score", lambda *_: None)
    monkeypatch.setattr(search, "noisy", lambda _: False)
    monkeypatch.setattr(search, "unrepeated", lambda *_: None)
    monkeypatch.setattr(search, "bars_of", lambda *_: Bars(0.0, 0.0))
    monkeypatch.setattr(search, "chosen", lambda m, k, scores, *_: Accepted(scores[0], (), 1))
    monkeypatch.setattr(search.Search, "scores_of", lambda _, axis: [better] if axis == 1 else [])
    unsure = SimpleNamespace(sure=False)
    moments = SimpleNamespace(without=lambda *_: moments, fit=lambda _: unsure)
    seen = SimpleNamespace(clear=lambda *_: True)
    hypotheses: Any = SimpleNamespace(rows=rows, moments=moments, seen=seen)
    accepted, _ = search.Search(hypotheses, USUAL).next(1)
    assert accepted is not None
    assert accepted.score is better


def fit_of(off: Array, seed: int) -> Joint:
    """A fit in which the first parameter is free of its tolerance."""
    B, y = drawn(off, seed)
    alone = np.arange(COUNT)
    rows = Layout(np.zeros(COUNT, dtype=int), alone * FOLDS // COUNT, alone // 20, alone)
    known = [Known(f"m[{k + 1}]", "kg", 2.0, 0.1, "m") for k in range(len(off))]
    model: Any = SimpleNamespace(
        regression=Regression(y, Design.of([B]), *np.ones((2, len(off))), rows),
        known=known,
        scale=np.full(len(off), 0.1),
    )
    q = model.regression.loosened({0: FREED}).q
    return Joint(SimpleNamespace(model=model), (), (), q, {0: FREED})  # type: ignore[arg-type]


def test_interval_holds_the_value() -> None:
    """At least as often as it says: rows are counted as going together."""
    hits = 0
    for seed in range(60):
        (change,) = changed_of(fit_of(np.array([30.0, 0.5, -0.5]), seed), [(0,)])
        assert (change.parameter, change.nominal, change.estimate.unit) == ("m[1]", 2.0, "kg")
        low, high = change.estimate.ci95
        hits += low < 2.0 + 30.0 * 0.1 < high
    assert hits >= 55


def test_of_a_body_those_are_given_that_differ() -> None:
    (change,) = changed_of(fit_of(np.array([30.0, 0.0, 0.0]), 3), [(0, 1, 2)])
    assert change.parameter == "m[1]"


def test_parameter_that_is_what_the_file_says_has_not_changed() -> None:
    """It left its tolerance beside a model that was still wrong elsewhere."""
    assert not changed_of(fit_of(np.zeros(3), 3), [(0,)])
    assert not changed_of(fit_of(np.zeros(3), 3), [(0, 1, 2)])


@pytest.mark.parametrize(("elsewhere", "accepted"), [((), False), ((1,), True)])
def test_same_effect_on_another_axis_needs_no_second_trajectory(
    elsewhere: tuple[int, ...], accepted: bool
) -> None:
    """One fold shows it, and the other one, which it predicts, hardly confirms it."""

    def on(axis: int) -> Any:
        return SimpleNamespace(axis=axis, id="friction", choices=1, exact=False)

    score = Score(on(0), 60.0, np.array([1.0, 59.0]), 0.01)
    known = [Score(on(axis), 60.0, np.array([20.0, 20.0]), 0.01) for axis in elsewhere]
    assert passes(score, known, BARS, USUAL) == accepted


def heavy(off: Array, seed: int = 1) -> tuple[Rows, HeavierBody]:
    """Rows of a body whose parameters are `off` by so many tolerances, 10 % of 2 kg each, beside
    one more parameter; the hypothesis that all of the body went with its mass."""
    B, y = drawn(np.append(off, 0.0), seed)
    count = len(off)
    rows = rows_of(y, B, np.ones(count + 1), np.arange(COUNT) * FOLDS // COUNT)
    direction = np.full(count, 10.0)
    return rows, HeavierBody("link", tuple(range(count)), None, direction=direction)


@pytest.mark.parametrize(("share", "changed"), [(0.05, False), (0.7, True), (-0.5, True)])
def test_mass_that_changed_takes_its_moments_with_it(share: float, changed: bool) -> None:
    """One number for all of a body is more likely than six that happen to go together."""
    rows, body = heavy(np.full(6, 10 * share))
    (score,) = change_scores(Moments(rows), [body], USUAL)
    assert passes(score, (), BARS, USUAL) == changed
    (apart,) = change_scores(Moments(rows), [ChangedParameter("link", body.places, None)], USUAL)
    assert not changed or score.gain > apart.gain


def test_mass_below_zero_is_no_hypothesis() -> None:
    """Whatever makes the torques smaller than without the body, it is not its mass."""
    counts = [
        change_scores(Moments(rows), [body], USUAL)
        for rows, body in (heavy(np.full(6, 10 * share)) for share in (-0.9, -1.2))
    ]
    assert [len(scores) for scores in counts] == [1, 0]


def test_body_with_another_mass_becomes_that_of_the_base_model() -> None:
    """What is then left has no mass in it, and the file's value is not forgotten."""
    rows, body = heavy(np.full(3, 7.0))
    known = [Known(f"link.{k}", "kg", 2.0, 0.2, "link") for k in range(3)]
    known.append(Known("other", "N m", 0.0, 0.1, "other"))
    y, B = (rows.y[0][:, None],), (rows.B,)
    base: Any = SimpleNamespace(linear=tuple(known))
    none: Any = SimpleNamespace()
    scale = np.full(4, 0.2)
    model = Calibrated(base, (), none, tuple(known), scale, y, B, (), none)
    bench: Any = SimpleNamespace(model=model, beside=lambda model: SimpleNamespace(model=model))
    heavier_model = heavier(bench, body, Moments(rows)).model
    assert [k.nominal for k in heavier_model.known[:3]] == pytest.approx([3.4] * 3, rel=0.03)
    assert [k.written for k in heavier_model.known] == [2.0, 2.0, 2.0, 0.0]
    assert heavier_model.base.linear == heavier_model.known
    # seven tolerances heavier: of what came nobody knows the place
    assert [k.wider for k in heavier_model.known] == pytest.approx([7.0, 7.0, 7.0, 1.0], rel=0.03)
    tight = np.array([k.wider for k in heavier_model.known]) ** -1.0
    prior = rows.prior * tight**2
    left = Moments(rows_of(heavier_model.y[0][:, 0], rows.B.whole(0), prior, rows.fold))
    assert np.abs(left.fit(None).q).max() < 0.3

    def lost(y: Array, tight: Array) -> float:
        """Half the sum of squares that a fit leaves, of torques and of parameters."""
        X = np.vstack([rows.B.whole(0), np.diag(tight)])
        return float(np.linalg.lstsq(X, np.append(y, np.zeros(4)))[1][0]) / 2

    gain = moved_gain(Moments(replace(left.rows, model=heavier_model)))
    # back in the file's tolerances, as none is wider for a body that did not change
    assert gain == pytest.approx(
        lost(rows.y[0], np.ones(4)) - lost(left.rows.y[0], tight), rel=1e-4
    )
    assert moved_gain(Moments(replace(rows, model=model))) == 0.0
    assert model.base.linear[0].nominal == 2.0

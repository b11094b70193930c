"""What held-out runs say of effects and parameters that others show."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.jointfit import elsewhere
from flexhex.diagnosis.selection import unrefuted as refuting
from flexhex.diagnosis.selection import validated as module
from flexhex.diagnosis.selection.choose import Accepted
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.scores import Score
from flexhex.diagnosis.selection.unrefuted import Fitted, better, refuted, unrefuted
from flexhex.diagnosis.selection.validated import Predicted, validated

Array = NDArray[np.float64]
TORQUE = np.array([10.0, 1.0])


def judged(own: Sequence[float], now: Sequence[float]) -> tuple[Any, Any]:
    """A fit that leaves `now` of held-out runs on two axes where the base model's own leaves `own`;
    and these."""
    block = SimpleNamespace(judged=np.ones((4, 2), dtype=bool))
    left = {"own": own, "now": now}
    others = SimpleNamespace(
        blocks=[block],
        there=SimpleNamespace(blocks=[block], noise=SimpleNamespace(repeats=False)),
        residual=lambda parts, beta, q: [np.ones((4, 2)) * left[q]],
    )
    model = SimpleNamespace(torque_rms=TORQUE, regression=SimpleNamespace(q="own"))
    return SimpleNamespace(bench=SimpleNamespace(model=model), parts=(), beta=(), q="now"), others


@pytest.mark.parametrize(
    ("after", "axes", "whole"),
    [((1.0, 1.0), [], False), ((2.0, 0.1), [0], False), ((0.9, 2.0), [1], True)],
)
def test_parameters_are_judged_on_all_axes_together(
    after: tuple[float, float], axes: list[int], whole: bool
) -> None:
    """Each relative to its torque: the first has ten times that of the second."""
    fit, others = judged((1.0, 1.0), after)
    assert refuted(fit, others) == (axes, whole)


@pytest.mark.parametrize(("left", "kept"), [((3.0, 0.1), True), ((3.0, 0.5), False)])
def test_parameters_that_help_other_axes_more_are_kept(
    left: tuple[float, float], kept: bool
) -> None:
    fit, others = judged((1.0, 0.4), left)
    without = SimpleNamespace(bench=fit.bench, parts=(), beta=(), q="own")
    assert better(fit, without, others) == kept  # type: ignore[arg-type]
    assert better(fit, without, others, 2.0), "not clearly worse"  # type: ignore[arg-type]


def accepted(name: str) -> Accepted:
    effect: Any = SimpleNamespace(id=name, axis=0)
    return Accepted(Score(effect, 50.0, np.zeros(2), 0.1), (), 1)


def explaining(monkeypatch: pytest.MonkeyPatch, left: Any) -> None:
    """Sets of effects leave of held-out runs what a function of their names says, row by row."""

    def of(_: Predicted, effects: Sequence[Accepted]) -> list[Array]:
        return [np.array(left(frozenset(each.score.hypothesis.id for each in effects)))]

    monkeypatch.setattr(Predicted, "_of", of)
    monkeypatch.setattr(module, "unpredicted", lambda _, rows: np.array([np.linalg.norm(rows[0])]))
    monkeypatch.setattr(module, "options", lambda *_: iter(()))


def kept_of(names: Sequence[str]) -> list[str]:
    bench: Any = SimpleNamespace(model=SimpleNamespace(torque_rms=np.ones(1)))
    others: Any = SimpleNamespace(there=None)
    kept = validated(bench, [accepted(name) for name in names], others, USUAL, (), {})
    return [each.score.hypothesis.id for each in kept]


@pytest.mark.parametrize("order", [["spring", "friction"], ["friction", "spring"]])
def test_order_of_effects_does_not_decide(
    order: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A spring that shows beside friction alone has its name, whichever was found first."""
    rows = {"": (0.8, 0.6), "spring": (0.75, 0.6), "friction": (0.0, 0.6)}

    def rest(names: frozenset[str]) -> tuple[float, float]:
        return (0.0, 0.1) if len(names) == 2 else rows["".join(names)]

    explaining(monkeypatch, rest)
    assert kept_of(order) == order


def test_effect_that_held_out_runs_do_not_show_has_no_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It makes a torque that is not there."""

    def rest(names: frozenset[str]) -> tuple[float, float]:
        return 0.6 if "friction" in names else 1.0, 0.1 if "wave" in names else 0.0

    explaining(monkeypatch, rest)
    assert kept_of(["friction", "wave"]) == ["friction"]


@pytest.mark.parametrize(("times", "named"), [(0.5, True), (1.0, True), (1.3, True), (1.5, False)])
def test_effect_explains_most_of_the_torque_that_it_makes(
    times: float, named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However little that is of what is left there: runs are slower, or have another rest. If it
    is nearly all of it, it may make more."""
    for beside, there in ((1.0, named), (0.0, True)):

        def rest(names: frozenset[str], beside: float = beside) -> tuple[float, float]:
            return beside, 0.2 * (1 - times) if names else 0.2

        explaining(monkeypatch, rest)
        assert kept_of(["friction"]) == ["friction"] * there


def test_effects_that_make_up_for_each_other_are_worse_than_none_together(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Beside the other one each explains something: the one that explains least goes."""
    left = {"drag": (0.0, 1.5), "drift": (3.0, 1.2), "dragdrift": (0.0, 1.2)}
    explaining(monkeypatch, lambda names: left["".join(sorted(names))])
    monkeypatch.setattr(refuting, "firm", lambda _, effects, *__: (effects, fit))
    fit: Any = SimpleNamespace(bench=SimpleNamespace(model=SimpleNamespace(torque_rms=np.ones(1))))
    worse = iter([([0], True), ([], False)])
    monkeypatch.setattr(refuting, "refuted", lambda *_: next(worse, ([], False)))
    others: Any = SimpleNamespace(there=None)
    now = Fitted([accepted(name) for name in ("drag", "drift")], fit, (), {})
    kept = unrefuted(now, others, USUAL, ())
    assert [each.score.hypothesis.id for each in kept.effects] == ["drag"]
    assert [each.score.hypothesis.id for each in kept.refused] == ["drift"]


def test_the_least_goes_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two effects that held-out runs speak against: without the one the other may be right."""
    left = {"drag": (1.5,), "drift": (2.0,), "dragdrift": (3.0,)}
    explaining(monkeypatch, lambda names: left["".join(sorted(names))])
    monkeypatch.setattr(refuting, "firm", lambda _, effects, *__: (effects, fit))
    fit: Any = SimpleNamespace(bench=SimpleNamespace(model=SimpleNamespace(torque_rms=np.ones(1))))
    worse = iter([([0], True), ([], False)])
    monkeypatch.setattr(refuting, "refuted", lambda *_: next(worse))
    others: Any = SimpleNamespace(there=None)
    now = Fitted([accepted(name) for name in ("drift", "drag")], fit, (), {})
    kept = unrefuted(now, others, USUAL, ())
    assert [each.score.hypothesis.id for each in kept.effects] == ["drag"]


def test_slow_torque_of_a_run_hides_no_effect() -> None:
    """Torques wander from run to run by more than an effect does. Noise that passes show says so:
    what is left is counted beyond it."""
    rng = np.random.default_rng(3)
    wander = np.cumsum(rng.standard_normal(4000))
    fast = 3.0 * np.sin(np.arange(4000.0))

    def size(left: Array, repeats: bool) -> float:
        block = SimpleNamespace(judged=np.ones((len(left), 1), dtype=bool))
        noise = SimpleNamespace(repeats=repeats, scale=np.ones(1))
        model: Any = SimpleNamespace(
            base=SimpleNamespace(n=1),
            blocks=[block],
            noise=noise,
            white=lambda _, values: np.diff(values[0])[:, None],
        )
        return float(module.unpredicted(model, [left[:, None]])[0])

    assert size(wander, True) < 0.5 * size(wander + fast, True)
    assert size(wander, False) > 0.9 * size(wander + fast, False)


def test_base_parameters_learn_from_held_out_runs_beside_what_they_know() -> None:
    """A parameter that the first runs hardly show is that of the held-out ones; one that they show
    well stays."""
    rng = np.random.default_rng(0)
    B = rng.standard_normal((500, 2))
    y = B @ [2.0, 2.0]
    there = Known((y,), B)
    fit: Any = SimpleNamespace(
        parts=(),
        beta=(),
        q=np.zeros(2),
        spread=np.diag([1e6, 1e-9]),
    )
    seen = elsewhere.Elsewhere.__new__(elsewhere.Elsewhere)
    seen.there = there  # type: ignore[assignment]
    (left,) = seen.updated(fit)
    np.testing.assert_allclose(left, 2.0 * B[:, 1], atol=0.3)


@dataclass(frozen=True)
class Known:
    """Rows y (R,) of columns B (R, 2), as `Elsewhere` asks for them."""

    y: tuple[Array]
    B: Array

    @property
    def regression(self) -> SimpleNamespace:
        return SimpleNamespace(gram=(self.B.T @ self.B, self.B.T @ self.y[0]))

    def residual(self, q: Array) -> list[Array]:
        return [self.y[0] - self.B @ q]

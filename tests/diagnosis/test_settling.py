"""The search begins anew beside the base model that its own answer leaves, until that stays."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis import mechanism
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit import beside as besides
from flexhex.diagnosis.jointfit import guard
from flexhex.diagnosis.jointfit.answer import joint
from flexhex.diagnosis.jointfit.beside import beside
from tests.diagnosis.test_selection import RMS, RUNS, bench_of

Array = NDArray[np.float64]

WIDTHS = [8e-3, 12e-3, 14e-3, 15e-3, 15e-3]
"""Of the base model after each search: beside a friction it finds back to its own."""


def searched(
    monkeypatch: pytest.MonkeyPatch,
    widths: list[float],
    named: bool = True,
    rotors: list[float] | None = None,
    geared: tuple[int, ...] = (),
    left: tuple[float, ...] = (),
    kept: int = -1,
) -> list[float]:
    """Widths beside which was searched; named: an effect was found; rotors: of the only axis, as
    the fits have them; geared: axes with an effect behind their rotor; left: by each search, where
    that is not one; kept: the search whose answer stands."""

    def fitted(width: float, rotor: float) -> Any:
        p = np.array([1.0, rotor])
        return SimpleNamespace(widths=np.array([width]), delay=0.0, late=1.0, p=p, losses=0.0)

    base, each = SimpleNamespace(rotors=(1,)), rotors or [1.0] * len(widths)
    models = [
        SimpleNamespace(base=base, fitted=fitted(*pair), forget=lambda: None)
        for pair in zip(widths, each, strict=True)
    ]
    requests: list[Any] = []

    def side(bench: Any, *more: Any) -> Any:
        requests.append(bench.model)
        fit = SimpleNamespace(bench=bench, geared=geared, parts=(), beta=())
        there = SimpleNamespace(fit=fit, remains=())
        rest = np.array([dict(enumerate(left)).get(len(requests) - 1, 1.0)])
        found = fit if named else None
        said = {"others": None, "judged": (), "side": there, "fit": found, "left": rest}
        return SimpleNamespace(bench=bench, **said)

    bench = lambda model, known: SimpleNamespace(  # noqa: E731
        model=model, effects={}, forget=lambda: None
    )
    monkeypatch.setattr(mechanism, "Bench", bench)
    monkeypatch.setattr(mechanism, "with_lag", lambda fit, deviations: None)
    monkeypatch.setattr(mechanism, "found", side)
    monkeypatch.setattr(mechanism, "before_of", lambda model, others: model)
    monkeypatch.setattr(mechanism, "beside", lambda fit: models[models.index(fit.bench.model) + 1])
    start: Any = models[0]
    before, last = mechanism.mechanism(start, [], [], lambda text: None)
    assert before is requests[0]  # type: ignore[comparison-overlap]
    assert last.fit.bench.model is requests[kept]
    return [float(m.fitted.widths[0]) for m in requests]


def test_search_goes_on_while_a_width_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    assert searched(monkeypatch, [8e-3, 15e-3, 15.1e-3, 1.0]) == [8e-3, 15e-3]


def test_width_that_stays_asks_for_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    assert searched(monkeypatch, [15e-3, 15.5e-3, 1.0]) == [15e-3]


def test_search_that_leaves_more_is_not_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    """In twice the square; what leaves a little more may be the better model."""
    assert searched(monkeypatch, WIDTHS, left=(1.0, 1.5), kept=0) == WIDTHS[:2]
    assert searched(monkeypatch, WIDTHS, left=(1.0, 1.3)) == WIDTHS[: mechanism.SEARCHES]


def test_search_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    assert searched(monkeypatch, WIDTHS) == WIDTHS[: mechanism.SEARCHES]


@pytest.mark.parametrize(("geared", "count"), [((0,), 2), ((), 1)])
def test_search_goes_on_while_the_rotor_of_a_gear_that_gives_way_moves(
    geared: tuple[int, ...], count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    widths, rotors = [15e-3, 15.1e-3, 15.2e-3, 15.3e-3], [1.0, 0.8, 0.79, 0.5]
    result = searched(monkeypatch, widths, rotors=rotors, geared=geared)
    assert result == widths[:count]


@pytest.mark.parametrize(
    ("delay", "left", "anew"), [(2e-3, 0.1, True), (2e-3, 0.3, False), (1e-4, 0, False)]
)
def test_search_goes_on_where_a_delay_moves_by_an_effect(
    delay: float, left: float, anew: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a torque of 1 N m that changes by 100 N m/s; an effect worth a name has 0.02."""
    monkeypatch.setattr(guard, "axis_rms", lambda *_: np.array([100.0]))
    monkeypatch.setattr(guard, "left_rms", lambda _: np.array([left]))

    def model(delay: float) -> Any:
        fitted = SimpleNamespace(widths=np.ones(1), delay=delay, p=np.ones(1), losses=0.0)
        base = SimpleNamespace(rotors=(0,), window=0.0)
        return SimpleNamespace(base=base, fitted=fitted, blocks=[], torque_rms=np.ones(1))

    fit: Any = SimpleNamespace(geared=(), parts=(), beta=(), bench=SimpleNamespace(effects={}))
    assert guard.moved(model(0.0), model(delay), fit, 0.02) == anew


def test_without_an_effect_there_is_nothing_to_search_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert searched(monkeypatch, WIDTHS, named=False) == WIDTHS[:1]


@pytest.mark.parametrize("repeated", [True, False])
def test_what_is_missing_is_no_noise(repeated: bool, tmp_path: Path) -> None:
    """Passes that repeat show their noise; else it is what friction and the base model left."""

    def friction(q: Array, v: Array, a: Array) -> Array:
        return 0.2 * RMS * np.tanh(v / 0.01)

    runs = [run for run in RUNS if repeated or run[1] == 1]
    model = bench_of(tmp_path, friction, runs).model
    assert model.noise.repeats == repeated
    after = beside(joint(Bench(model, []), ()))
    assert after.noise.scale == pytest.approx(model.noise.scale, rel=0.1)


def test_fit_that_goes_astray_beside_friction_is_not_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Products between passes of what hardly repeats may have any sign."""
    fit = joint(Bench(bench_of(tmp_path, lambda q, v, a: 0.0 * q, RUNS).model, []), ())

    def astray(_: Any, bench: Any) -> Any:
        there = joint(bench, ())
        vars(there)["residual"] = [10.0 * left for left in fit.residual]
        return there

    assert beside(fit) is not fit.bench.model
    monkeypatch.setattr(besides, "again", astray)
    assert beside(fit) is fit.bench.model

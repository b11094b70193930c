"""Selection: what is named on a single axis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.result.rest import UNCONFIRMED
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.found import found
from flexhex.diagnosis.selection.nameless import nameless, tolerated
from flexhex.diagnosis.selection.select import Selection, select
from tests.diagnosis.single import SECONDS, TS, moved, thinned, wanted, write

Array = NDArray[np.float64]
CLOCK = np.arange(round(SECONDS / TS)) * TS
RMS = float(wanted(CLOCK, 1).std())
RUNS = ((1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2))
Torque = Callable[[Array, Array, Array], Array]
"""Of angle, rate, acceleration."""


def bench_of(
    folder: Path,
    torque: Torque | None,
    runs: Sequence[tuple[int, int]] = RUNS,
    step: int = 1,
    zero: float = 0.0,
) -> Bench:
    """Runs (motion, pass) of an axis that feels a further torque [N m]; every so many samples of
    them, zero [rad] off."""
    paths = []
    for k, (motion, number) in enumerate(runs):
        extra = 0.0 if torque is None else torque(*moved(CLOCK, motion))
        path = write(folder / f"{k}.csv", motion, number, 0.0, extra=extra, zero=zero)
        paths.append(thinned(path, step))
    base, run_set, trouble = run_set_of(paths, [], None, Options(base="axis"))
    assert not trouble
    model, _, _ = fitted(base, run_set.runs)
    return Bench(model, compiled(1, None, model.base.holds))


def chosen(folder: Path, torque: Torque | None) -> Selection:
    """What is chosen there."""
    return select(bench_of(folder, torque))


def names(selection: Selection) -> list[str]:
    return [accepted.score.hypothesis.id for accepted in selection.accepted]


def test_nothing_is_chosen_where_nothing_is_hidden(tmp_path: Path) -> None:
    selection = chosen(tmp_path, None)
    assert not names(selection)
    assert not nameless(selection, USUAL)


@pytest.mark.sample(1)
@pytest.mark.parametrize("order", [18.0, 53.0, 211.0])
def test_cogging_is_named_with_its_order_and_nothing_else(order: float, tmp_path: Path) -> None:
    selection = chosen(tmp_path, lambda q, v, a: 0.01 * RMS * np.sin(order * q + 0.4))
    (accepted,) = selection.accepted
    assert accepted.score.hypothesis.id == "cogging_harmonic"
    assert not accepted.rivals
    shape = accepted.score.hypothesis.shapes[accepted.score.shape]  # type: ignore[union-attr]
    assert shape["order"] == pytest.approx(order, abs=0.3)
    # the smoothing window takes more of a higher order: of the last 0.24
    assert 0.7 < accepted.score.size / (0.01 / np.sqrt(2)) < 1.05
    assert not nameless(selection, USUAL)


def test_two_effects_on_one_axis_are_both_named(tmp_path: Path) -> None:
    def both(q: Array, v: Array, a: Array) -> Array:
        return 0.02 * RMS * np.tanh(v / 0.01) + 0.01 * RMS * np.sin(80.0 * q)

    selection = chosen(tmp_path, both)
    assert sorted(names(selection)) == ["cogging_harmonic", "coulomb_friction"]
    assert not nameless(selection, USUAL)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "strange",
    [
        lambda q, v, a: 0.06 * RMS * np.exp(-(((q - 0.1) / 0.05) ** 2)),
        lambda q, v, a: 0.03 * RMS * np.tanh(v) * np.sin(5.0 * q),
    ],
    ids=["bump", "rate times angle"],
)
def test_what_the_library_has_not_is_left_without_a_name(strange: Torque, tmp_path: Path) -> None:
    """Names that fit a part of it are imitations: a smooth function predicts better than they."""
    selection = chosen(tmp_path, strange)
    functions = nameless(selection, USUAL)[0]
    sizes = tolerated(selection.accepted, selection.explained[0], USUAL)
    assert functions.size > max(sizes, default=0.0)


def test_one_trajectory_names_nothing(tmp_path: Path) -> None:
    """Two passes of it show that something repeats, not what it is."""
    bench = bench_of(tmp_path, lambda q, v, a: 0.02 * RMS * np.sin(53.0 * q), RUNS[:2])
    side = found(bench, (), lambda text: None).side
    assert not side.named
    assert side.remains == (0,)
    (rest,) = side.rests
    assert (rest.fitted, rest.why) == (("cogging_harmonic",), UNCONFIRMED)

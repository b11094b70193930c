"""The search beside several effects of one axis: as many as there are, each with its own shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.runs.run import Run
from flexhex.diagnosis.selection import found as finding
from flexhex.diagnosis.selection import seen
from flexhex.diagnosis.selection.changed import ChangedParameter
from flexhex.diagnosis.selection.choose import Accepted
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.found import found
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.nameless import nameless, tolerated
from flexhex.diagnosis.selection.orders import Orders
from flexhex.diagnosis.selection.rows import Rows
from flexhex.diagnosis.selection.scores import Score
from flexhex.diagnosis.selection.select import Selection, select
from tests.diagnosis.single import write
from tests.diagnosis.test_selection import CLOCK, RMS, RUNS, bench_of, chosen, moved, names

Array = NDArray[np.float64]
several = pytest.mark.sample(2, of="several effects of an axis")
ORDERS = (29.0, 58.0, 87.0, 116.0, 145.0)


def orders(selection: Selection) -> list[float]:
    """Of the harmonics that were accepted, ascending."""
    listed = [a.score.order for a in selection.accepted]
    return sorted(order for order in listed if order is not None)


@several
def test_all_harmonics_of_an_axis_are_named(tmp_path: Path) -> None:
    """With their common torque, and nothing else."""
    selection = chosen(tmp_path, lambda q, v, a: 0.01 * RMS * sum(np.sin(n * q) for n in ORDERS))
    assert names(selection) == ["cogging_harmonic"] * len(ORDERS)
    np.testing.assert_allclose(orders(selection), ORDERS, atol=0.5)
    assert not nameless(selection, USUAL)
    whole = 0.01 * np.sqrt(len(ORDERS) / 2)
    # the smoothing window takes more of a higher order
    assert 0.6 * whole < selection.explained[0] < 1.05 * whole


@pytest.mark.parametrize(("size", "freed"), [(0.06, []), (0.0, [0])], ids=["bump", "nothing"])
def test_no_parameter_is_set_free_where_nothing_has_a_name(
    size: float, freed: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It would only imitate what is left."""
    selection = chosen(tmp_path, lambda q, v, a: size * RMS * np.exp(-(((q - 0.1) / 0.15) ** 2)))
    change = Score(ChangedParameter("J", (0,), None), 100.0, np.zeros(3), 0.1)
    extended = replace(selection, accepted=(*selection.accepted, Accepted(change, (), 1)))
    monkeypatch.setattr(finding, "select", lambda *_: extended)
    assert list(found(selection.bench, (), lambda text: None).side.fit.freed) == freed


def test_effects_that_imitate_what_has_no_name_stay_in_the_fit(tmp_path: Path) -> None:
    """Parameters would take their place, also on other axes."""
    selection = chosen(tmp_path, lambda q, v, a: 0.06 * RMS * np.exp(-(((q - 0.1) / 0.15) ** 2)))
    side = found(selection.bench, (), lambda text: None).side
    assert not side.named
    assert side.remains == (0,)
    assert {part.id for part in side.fit.parts} == {"cogging_harmonic"}
    assert any("in the fit, but not named" in note for note in side.notes)


def accepted(*given: tuple[float, float | None], varied: bool = False) -> list[Any]:
    """Effects with these sizes and orders."""
    form = SimpleNamespace(varied=varied)
    return [
        SimpleNamespace(score=SimpleNamespace(size=s, order=order, hypothesis=form))
        for s, order in given
    ]


def test_what_may_remain_is_a_share_of_each_effect_and_harmonics_count_together() -> None:
    most = USUAL.largest_rest
    assert tolerated(accepted((0.2, 29.0)), 0.1, USUAL) == [pytest.approx(most * 0.1)]
    both = tolerated(accepted((0.03, None), (0.04, None)), 0.1, USUAL)
    assert both == [pytest.approx(most * 0.06), pytest.approx(most * 0.08)]
    waves = tolerated(accepted((0.03, 29.0), (0.04, 58.0)), 0.1, USUAL)
    assert waves == [pytest.approx(most * 0.1)] * 2
    others = tolerated(accepted((0.03, 29.0), (0.04, 41.0)), 0.1, USUAL)
    assert others == [pytest.approx(most * 0.06), pytest.approx(most * 0.08)]
    assert tolerated((), 0.1, USUAL) == []


def test_more_may_remain_beside_friction() -> None:
    """Coulomb friction and a spring that explain as much."""
    friction, spring = accepted((0.03, None), (0.03, None))
    friction.score.hypothesis = SimpleNamespace(varied=True)
    one = 0.1 * 0.5**0.5
    wanted = [pytest.approx(share * one) for share in (USUAL.varied_rest, USUAL.largest_rest)]
    assert tolerated([friction, spring], 0.1, USUAL) == wanted


@pytest.mark.parametrize("held_out", [(2, ["cogging_harmonic"]), (0, [])], ids=["there", "not"])
def test_one_trajectory_names_what_predicts_another_one(
    held_out: tuple[int, list[str]], tmp_path: Path
) -> None:
    bench, judged = one_trajectory(tmp_path, {1: 0.02, 2: 0.01 * held_out[0]})
    side = found(bench, judged, lambda text: None).side
    assert [named.id for named in side.named] == held_out[1]


def test_next_best_name_is_given_where_it_predicts_another_trajectory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the best one does not."""
    bench, judged = one_trajectory(tmp_path, {1: 0.02, 2: 0.02})
    selection = select(bench, replace(USUAL, most=1))
    (wave,) = selection.accepted
    others = [s for s in selection.rounds[0] if s.hypothesis.id != "cogging_harmonic"]
    mistaken = replace(wave, score=others[0], rivals=())
    monkeypatch.setattr(finding, "select", lambda *_: replace(selection, accepted=(mistaken,)))
    answer = found(bench, judged, lambda text: None).side
    assert [named.id for named in answer.named] == ["cogging_harmonic"]
    assert answer.named[0].rivals == ()
    assert answer.notes[0] == (
        f"{others[0].hypothesis.id} on axis 1 would fit, but not on the held-out runs"
    )


@pytest.mark.parametrize(("there", "named"), [(1.0, ["cogging_harmonic"]), (-1.0, [])])
def test_effect_that_makes_held_out_runs_worse_has_no_name(
    there: float, named: list[str], tmp_path: Path
) -> None:
    """However well two trajectories agree on it; what it explains of these is told as left."""
    paths = []
    for k, (motion, number) in enumerate([*RUNS[:4], (3, 1)]):
        torque = 0.02 * RMS * np.sin(53.0 * moved(CLOCK, motion)[0])
        torque *= there if motion == 3 else 1.0
        paths.append(write(tmp_path / f"{k}.csv", motion, number, 0.0, extra=torque))
    base, run_set, _ = run_set_of(paths[:4], paths[4:], None, Options(base="axis"))
    model, _, _ = fitted(base, run_set.runs)
    bench = Bench(model, compiled(1, None, model.base.holds))
    answer = found(bench, run_set.judged, lambda text: None).side
    assert [effect.id for effect in answer.named] == named
    assert any("but not on the held-out runs" in note for note in answer.notes) == (not named)
    assert answer.remains == (() if named else (0,))


def one_trajectory(folder: Path, size: Mapping[int, float]) -> tuple[Bench, list[Run]]:
    """Two passes of a motion with a wave of so much of the torque's RMS, and the runs of another
    motion that judge."""
    paths = []
    for k, (motion, number) in enumerate(RUNS[:4]):
        torque = size[motion] * RMS * np.sin(53.0 * moved(CLOCK, motion)[0])
        paths.append(write(folder / f"{k}.csv", motion, number, 0.0, extra=torque))
    base, run_set, _ = run_set_of(paths[:2], paths[2:], None, Options(base="axis"))
    model, _, _ = fitted(base, run_set.runs)
    return Bench(model, compiled(1, None, model.base.holds)), list(run_set.judged)


def test_rows_that_show_no_wave_ask_for_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of few places nothing periodic can be told; all else is asked for as ever."""
    bench = bench_of(tmp_path, None)
    candidates = Hypotheses(bench, Rows.of(bench.model))
    requests = [effect.id for effect in candidates.effects(0)]
    monkeypatch.setattr(seen, "promising_orders", lambda *_: Orders((), 0, ()))
    blind = Hypotheses(bench, candidates.rows)
    waves = {"cogging_harmonic", "torque_ripple"}
    assert [effect.id for effect in blind.effects(0)] == [a for a in requests if a not in waves]
    (other, *_) = (e for e in candidates.effects(0) if e.id == "cogging_harmonic")
    assert blind.anew(candidates.moments, other, "something", []) == []


def test_wave_of_another_axis_is_not_tried_where_too_little_of_it_is_seen(tmp_path: Path) -> None:
    """Its whole multiples are, as soon as they fit into the stroke."""
    bench = bench_of(tmp_path, None)
    candidates = Hypotheses(bench, Rows.of(bench.model))
    (wave,) = (e for e in candidates.effects(0) if e.id == "cogging_harmonic")
    (shape,) = bench.searched("cogging_harmonic", 0)
    (tried,) = candidates.anew(candidates.moments, wave, "", [0.6 * shape.low])
    orders = [own["order"] / shape.low for own in tried.shapes]
    assert orders == pytest.approx([1.2, 1.8, 2.4, 3.0])
    assert candidates.anew(candidates.moments, wave, "", [0.1 * shape.low]) == []

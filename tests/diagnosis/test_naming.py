"""Effects in the answer: the largest first, no interval beyond what has a sense."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.jointfit.answer import Joint, joint
from flexhex.diagnosis.jointfit.effects import Part, SelectedEffect
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.result.naming import named_of, unnamed_parts
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads_arm import planar
from tests.diagnosis.test_selection import RMS, bench_of

Array = NDArray[np.float64]
__all__ = ["planar"]


def friction_and_wave(q: Array, v: Array, a: Array) -> Array:
    return 0.05 * RMS * np.tanh(v / 0.01) + 0.02 * RMS * np.sin(29.0 * q)


@pytest.mark.parametrize("order", [1, -1])
def test_largest_effect_is_named_first(order: int, tmp_path: Path) -> None:
    bench = bench_of(tmp_path, friction_and_wave)
    shapes = {"coulomb_friction": {"s_0": 1e-4, "v_0": 0.0}, "cogging_harmonic": {"order": 29.0}}
    effects = [
        SelectedEffect(name, (Part.of(bench, name, 0, shape),))
        for name, shape in list(shapes.items())[::order]
    ]
    named = named_of(joint(bench, effects), [0.0, 0.0])
    assert [effect.id for effect in named] == ["coulomb_friction", "cogging_harmonic"]


def test_interval_of_a_positive_value_does_not_go_below_zero(tmp_path: Path) -> None:
    """A wave's sine and cosine may be anything; nothing is known of a shape without an interval."""
    bench = bench_of(tmp_path, friction_and_wave)
    part = Part.of(bench, "coulomb_friction", 0, {"s_0": 1e-4, "v_0": 0.0})
    fit = joint(bench, [SelectedEffect("coulomb_friction", (part,))])

    def told(deviation: float, **gains: Any) -> Joint:
        other = replace(fit)
        shapes, bent = [{"s_0": deviation, "v_0": 0.0}], [{"s_0": 0.0, "v_0": 0.0}]
        vars(other)["deviations"] = replace(fit.deviations, shapes=shapes, bent=bent, **gains)
        return other

    (effect,) = named_of(told(1.0, gains=fit.beta[0]), [0.0])
    (lost,) = named_of(told(np.inf), [0.0])
    assert effect.parameters["F_c"].ci95[0] == 0.0
    assert effect.parameters["s_0"].ci95[0] == 0.0
    assert effect.parameters["F_c"].ci95[1] == pytest.approx(2.96 * fit.beta[0][0])
    assert lost.parameters["s_0"].ci95 == (-np.inf, np.inf)


def test_note_has_no_unit_1(tmp_path: Path) -> None:
    """`g 0.1 1` would read as two numbers."""
    bench = bench_of(tmp_path, friction_and_wave)
    part = Part.of(bench, "torque_ripple", 0, {"order": 29.0})
    (note,) = unnamed_parts(joint(bench, [SelectedEffect("torque_ripple", (part,))]), [0])
    assert re.search(r"\(a [-\de.]+, b [-\de.]+, order [\d.]+ 1/rad\): in the fit", note)


@pytest.mark.parametrize(("axes", "rivals"), [((1,), ("coulomb_friction",)), ((0, 1), ())])
def test_name_on_another_axis_may_be_the_right_one_here(
    axes: tuple[int, ...], rivals: tuple[str, ...], planar: str, tmp_path: Path
) -> None:
    """What the same axis has beside is no other name for it."""
    paths = []
    for motion, number in ((1, 1), (1, 2), (2, 1), (2, 2)):
        run = two_links.run(motion, number, 0.0, (0.0, 0.0))
        rate = two_links.moved(run["time"], motion)[1]
        run["tau_meas"] += np.tanh(rate / 1e-3) + np.array([1.0, 0.0])
        head = {"trajectory": str(motion), "pass": str(number)}
        paths.append(plain_csv(tmp_path / f"{motion}{number}.csv", run, **head))
    base, run_set, _ = run_set_of(paths, [], None, Options(base=planar))
    model, _, _ = fitted(base, run_set.runs)
    bench = Bench(model, compiled(2, None, model.base.holds))
    friction = tuple(
        Part.of(bench, "coulomb_friction", axis, {"s_0": 1e-4, "v_0": 0.0}) for axis in axes
    )
    offset = Part.of(bench, "torque_offset", 0, {}, rivals=("coulomb_friction",))
    effects = [
        SelectedEffect("coulomb_friction", friction),
        SelectedEffect("torque_offset", (offset,)),
    ]
    named = {effect.id: effect for effect in named_of(joint(bench, effects), [0.0] * 3)}
    assert named["torque_offset"].rivals == rivals

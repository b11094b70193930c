"""What is too faint for a name bends the values of what has one: their intervals say so."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.naming import widened
from flexhex.diagnosis.result.verdict import Named
from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis import two_links
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads_arm import planar

__all__ = ["planar"]
DRY, WET = 0.4, 0.06
"""Friction of the second joint [N m], and what grows with the rate [N m s/rad]."""


def named(name: str, *parts: tuple[int, tuple[float, float]]) -> Named:
    """An effect with one parameter on each of these axes, by its interval."""
    estimates = [(axis, {"F": Estimate(1.0, ends, "N m")}) for axis, ends in parts]
    return Named(name, name, tuple(axis for axis, _ in parts), {}, tuple(estimates))


def test_intervals_hold_other_values_too_where_there_are_any() -> None:
    """An axis that has an effect twice, and an effect that is no finding beside the others."""
    own = [
        named("drag", (1, (0.9, 1.1)), (1, (0.8, 1.2)), (2, (0.7, 1.3))),
        named("dent", (1, (0.9, 1.1))),
    ]
    others = [named("drag", (1, (0.5, 1.0)), (1, (1.0, 1.5)))]
    drag, dent = widened(own, others)
    ends = [estimates["F"].ci95 for _, estimates in drag.parts]
    assert ends == [(0.5, 1.1), (0.8, 1.5), (0.7, 1.3)]
    assert drag.parameters["F[1]#2"].ci95 == (0.8, 1.5)
    assert dent.parameters["F"].ci95 == (0.9, 1.1)


def test_dry_friction_may_be_less_by_what_grows_with_the_rate(planar: str, tmp_path: Path) -> None:
    """That is too little for a name, and a tenth of the dry friction."""
    paths = []
    for motion, number in ((1, 1), (1, 2), (2, 1), (2, 2)):
        run = two_links.run(motion, number, 0.0, (0.0, 0.0))
        rate = two_links.moved(run["time"], motion)[1][:, 1]
        run["tau_meas"][:, 1] += DRY * np.tanh(rate / 0.01) + WET * rate
        paths.append(plain_csv(tmp_path / f"{motion}{number}.csv", run))
    diagnosis = diagnose(paths, options=Options(base=planar))
    (effect,) = diagnosis.effects
    assert (effect.id, effect.axes) == ("coulomb_friction", (2,))
    estimate = effect.parameters["F_c"]
    assert estimate.ci95[0] < DRY < estimate.value
    assert any("viscous friction on axis 2" in note for note in diagnosis.notes)

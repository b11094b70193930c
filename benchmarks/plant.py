"""The plant's tick, and whether its error stays below a step of the encoder."""

from __future__ import annotations

import numpy as np

from benchmarks.blocks import Array, Instance, block
from benchmarks.clock import Rival, Row, Run, measure
from benchmarks.motion import ROWS, poses, torques
from flexhex.fmus.common.machine.machine import Machine

FINE = 32
"""Substeps of what counts as exact."""
SCHEMES: dict[str, tuple[str, ...]] = {
    "plant, one evaluation": (),
    "Runge-Kutta, four": ("-DPLANT_CLASSICAL",),
}
"""Flags of step.c for each scheme; ours first."""
SMOOTH = {"theta_step": 0.0, "tau_step": 0.0}


def torque_rows(machine: Machine) -> Array:
    """tau and payload (rows, 7): torques of the motion at the plant's rate; each torque of the
    feedforward acts for two of its ticks, as in the loop."""
    tau = np.repeat(torques(machine, poses(machine, ROWS)), 2, axis=0)
    return np.hstack([tau, np.zeros((len(tau), 1))])


def plant(machine: Machine, rows: Array, scheme: str, **parameters: float) -> Instance:
    """A plant that integrates by one of SCHEMES."""
    return block("plant", machine, rows, SCHEMES[scheme], **parameters)


def path(one: Instance, ticks: int = 2000) -> Array:
    """theta (ticks, 6) [rad]."""
    angles = []
    for _ in range(ticks):
        one.ticks(1)
        angles.append(one.output("theta"))
        _moving(one)
    return np.array(angles)


def _moving(one: Instance) -> None:
    if one.output("fault").any():
        raise ValueError("the plant ran into an end stop: the figures would mean nothing")


def errors(machine: Machine, rows: Array) -> dict[str, tuple[float, float]]:
    """Largest error of theta [rad] over 0.25 s and over 0.5 s for each scheme, no quantisation.

    Open loop and from rest into a torque that jumps: nothing takes an error out again. Exact are
    fine substeps of the other scheme.
    """
    deviations = {}
    for scheme, other in zip(SCHEMES, reversed(SCHEMES), strict=True):
        exact = path(plant(machine, rows, other, substeps=FINE, **SMOOTH))
        off = np.abs(path(plant(machine, rows, scheme, **SMOOTH)) - exact)
        deviations[scheme] = (float(np.max(off[: len(off) // 2])), float(np.max(off)))
    return deviations


def from_rest(one: Instance) -> Run:
    """Ticks from the start of the motion, every time: later it would be at an end stop."""
    start = one.s.copy()

    def run(count: int) -> float:
        one.s[:], one.c.at = start, 0
        spent = one.ticks(count)
        _moving(one)
        return spent

    return run


def plant_row(machine: Machine, rounds: int) -> Row:
    """One tick of 0.25 ms by either scheme."""
    rows = torque_rows(machine)
    rivals = [Rival(name, from_rest(plant(machine, rows, name))) for name in SCHEMES]
    notes = [
        f"{scheme}, open loop: off by {early:.2g} rad within 0.25 s, {late:.2g} within 0.5 s;"
        f" a step of the encoder is {machine.encoder.step:.2g}"
        for scheme, (early, late) in errors(machine, rows).items()
    ]
    return Row("plant", "plant, 0.25 ms", measure(rivals, rounds), 45e3, 4.7e3, notes=notes)

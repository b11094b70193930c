"""The plant's tick, and whether its error stays below a step of the encoder."""

from __future__ import annotations

import numpy as np

from benchmarks.clock import Rival, Row, measure
from benchmarks.motion import ROWS, poses, torques
from benchmarks.rooms import Array, Instance, room
from flexhex.fmus.common.machine.machine import Machine

FINE = 16
"""Substeps of what counts as exact."""


def torque_rows(machine: Machine) -> Array:
    """tau and payload (rows, 7): torques of the motion at the plant's rate; each torque of the
    feedforward acts for two of its ticks, as in the loop."""
    tau = np.repeat(torques(machine, poses(machine, ROWS)), 2, axis=0)
    return np.hstack([tau, np.zeros((len(tau), 1))])


def plant(machine: Machine, rows: Array, substeps: int, quantised: bool = True) -> Instance:
    """A plant with so many integration steps a tick."""
    off = {} if quantised else {"theta_step": 0.0, "tau_step": 0.0}
    return room("plant", machine, rows, substeps=substeps, **off)


def path(machine: Machine, rows: Array, substeps: int, ticks: int = 2000) -> Array:
    """theta (ticks, 6) [rad], not quantised."""
    one = plant(machine, rows, substeps, quantised=False)
    found = []
    for _ in range(ticks):
        one.ticks(1)
        found.append(one.output("theta"))
        if one.output("fault").any():
            raise ValueError("the plant ran into an end stop: the error would mean nothing")
    return np.array(found)


def errors(machine: Machine, rows: Array) -> dict[int, tuple[float, float]]:
    """Largest error of theta [rad] over 0.25 s and over 0.5 s, for one and two substeps.

    Open loop and from rest into a torque that jumps: nothing takes an error out again.
    """
    exact = path(machine, rows, FINE)
    found = {}
    for substeps in (1, 2):
        off = np.abs(path(machine, rows, substeps) - exact)
        found[substeps] = (float(np.max(off[: len(off) // 2])), float(np.max(off)))
    return found


def plant_row(machine: Machine, rounds: int) -> Row:
    """One tick of 0.25 ms against the same scheme with two substeps."""
    rows = torque_rows(machine)
    one, two = plant(machine, rows, 1), plant(machine, rows, 2)
    rivals = [Rival("plant, RK4, one step", one.ticks), Rival("RK4, two substeps", two.ticks)]
    notes = [
        f"{substeps} substep(s), open loop: off by {early:.2g} rad within 0.25 s,"
        f" {late:.2g} within 0.5 s; a step of the encoder is {machine.encoder.step:.2g}"
        for substeps, (early, late) in errors(machine, rows).items()
    ]
    return Row("plant", "plant, 0.25 ms", measure(rivals, rounds), 45e3, 20e3, notes=notes)

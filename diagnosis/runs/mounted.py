"""Machines that stand otherwise than their file says, on a wall or under a ceiling; and torques
without the weight, as a controller may log them.

Gravity is then another vector in the frame of the foot. Its torque is linear in it,

    tau = tau_0 + W g + friction and rotors,    W (samples, n, 3),

so the vector that leaves least is found at once. Its length is known.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base, Standing
from flexhex.diagnosis.runs.arrangements import Arrangement, Seen
from flexhex.diagnosis.runs.nominal import beside_friction, nominal_torque, weights_of

Array = NDArray[np.float64]
TILTED = 0.1
"""Angle [rad] from which a machine stands otherwise; less is an error of its feet, which is a
parameter."""


def mounted(base: Base, seen: Sequence[Seen]) -> list[Arrangement]:
    """No gravity, and gravity from where it leaves least beside friction; nothing of a base model
    that does not know its own."""
    if not isinstance(base, Standing) or not base.gravity.any():
        return []
    given = base.gravity
    W = np.concatenate([weights_of(base, s) for s in seen])
    still = nominal_torque(base, seen) - W @ given
    G, b = np.zeros((3, 3)), np.zeros(3)
    for i in range(base.n):
        own, others, tau = beside_friction(seen, still[:, i], i)
        unit = max(float(np.concatenate([s.tau[:, i] for s in seen]).std()), 1e-300)
        columns = np.column_stack([W[:, i] / unit, tau - own])
        columns -= others @ np.linalg.lstsq(others, columns)[0]
        G += columns[:, :3].T @ columns[:, :3]
        b += columns[:, :3].T @ columns[:, 3]
    way = np.linalg.lstsq(G, b)[0]
    length = float(np.linalg.norm(given))
    other = way * length / max(float(np.linalg.norm(way)), 1e-300)
    listed = [_with(base, np.zeros(3), "do the logged torques carry no weight?")]
    if np.linalg.norm(other - given) > TILTED * length:
        asked = "does the machine stand otherwise than its file says?"
        listed.append(_with(base, np.asarray(other), asked))
    return listed


def _with(base: Base, gravity: Array, asked: str) -> Arrangement:
    values = ", ".join(f"{value:.2g}" for value in gravity)
    text = (
        f"gravity = [{values}] m/s2 in the frame of the foot ({asked} What `flexhex init"
        " robot.toml` writes has a place for it)"
    )
    ones = np.ones(base.n)
    return Arrangement(text, tuple(range(base.n)), ones, ones, gravity=gravity)

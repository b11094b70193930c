"""A serial arm of rigid links: its description, its torques, and the errors of its geometry."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Known
from flexhex.diagnosis.kinds import ROTARY, Kind
from flexhex.fmus.common.inertia import inertia_rows
from flexhex.fmus.common.machine.sections import Tolerance
from flexhex.fmus.common.model.rigid_tree import Body, Joint, torques

Array = NDArray[np.float64]
AS_BODIES = (0, 3, 5, 1, 2, 4)
"""Where J_xx, J_yy, J_zz, J_xy, J_xz, J_yz stand among the six J of `newton_euler`."""
MISPLACED = (("x", "m"), ("y", "m"), ("z", "m"), ("roll", "rad"), ("pitch", "rad"), ("yaw", "rad"))
"""Errors of a joint's frame and their units."""


@dataclass(frozen=True)
class Link:
    """A link that turns about its own z axis, or slides along it.

    at (3,) [m], rpy (3,) [rad]: where its axis stands in the link before (x, then y, then z of
    the fixed frame); mass [kg]; centre (3,) [m] of mass in its own frame; kind: of its joint.
    """

    at: tuple[float, float, float]
    rpy: tuple[float, float, float]
    mass: float
    centre: tuple[float, float, float]
    kind: Kind = ROTARY


@dataclass(frozen=True)
class Arm:
    """Links from the foot on; gravity (3,) [m/s2] as far as the reported torques carry it.

    spread: tolerance of masses and moments, relative; 0 where the runs cannot better them.
    misplaced: tolerance of the joints' places, relative to the longest link, and of their
    directions and gravity's [rad]; 0: they are taken as they are.
    """

    links: tuple[Link, ...]
    gravity: tuple[float, float, float]
    spread: float = 0.0
    misplaced: float = Tolerance().geometry


def newton_euler(
    arm: Arm, theta: ca.SX, thetad: ca.SX, thetadd: ca.SX, p: ca.SX, e: ca.SX | None = None
) -> ca.SX:
    """Torques (n,) [N m], or forces [N], of links with ten parameters each, p (10 n,).

    e: errors of geometry, small, in the order of `misplacements`.
    """
    z = ca.SX([0, 0, 1])
    g, frames = _frames(arm, ca.SX.zeros(len(misplacements(arm))) if e is None else e)
    joints = [
        Joint(k - 1, r, R, z, link.kind.turns)
        for k, ((r, R), link) in enumerate(zip(frames, arm.links, strict=True))
    ]
    tens = [p[10 * k : 10 * k + 10] for k in range(len(joints))]
    bodies = [
        Body(ten[0], ten[1:4], ca.blockcat(inertia_rows([ten[4 + j] for j in AS_BODIES])))
        for ten in tens
    ]
    return torques(joints, bodies, g, theta, thetad, thetadd)


def misplacements(arm: Arm) -> list[Known]:
    """Errors of geometry: gravity's direction as turns about the foot's axes, then of each joint
    but the first its place in the link before (x, y, z) and its direction, as turns about its own
    axes (roll, pitch, yaw; the last is an offset of its angle).

    The first joint's are those of gravity, or nothing that the torques show.
    """
    length = max(float(np.linalg.norm(link.at)) for link in arm.links[1:] or arm.links)
    listed = [
        Known(f"gravity.{axis}", "rad", 0.0, arm.misplaced, f"gravity.{axis}")
        for axis, moved in zip("xyz", np.cross(arm.gravity, np.eye(3)), strict=True)
        if moved.any()
    ]
    for k in range(2, len(arm.links) + 1):
        for name, unit in MISPLACED:
            name, size = f"link[{k}].{name}", length if unit == "m" else 1.0
            listed.append(Known(name, unit, 0.0, arm.misplaced * size, name))
    return listed


def _frames(arm: Arm, e: ca.SX) -> tuple[ca.SX, list[tuple[ca.SX, ca.SX]]]:
    """Gravity (3,) and of each joint place (3,) and rotation (3, 3), with errors e."""
    g = ca.SX(list(arm.gravity))
    frames = [(ca.SX(list(link.at)), ca.SX(rotation(link.rpy))) for link in arm.links]
    turns = [axis for axis in np.eye(3) if np.cross(arm.gravity, axis).any()]
    for k, axis in enumerate(turns):
        g = g + e[k] * ca.SX(np.cross(axis, arm.gravity))
    for k in range(1, len(frames)):
        own = e[len(turns) + 6 * (k - 1) : len(turns) + 6 * k]
        r, R = frames[k]
        frames[k] = (r + own[:3], R + ca.mtimes(R, ca.skew(own[3:])))
    return g, frames


def rotation(rpy: tuple[float, float, float]) -> Array:
    """Rotation (3, 3) about fixed x, then y, then z."""
    (sx, sy, sz), (cx, cy, cz) = np.sin(rpy), np.cos(rpy)
    X = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    Y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    Z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return np.asarray(Z @ Y @ X)

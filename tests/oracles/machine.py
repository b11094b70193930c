"""The machine file as plain arrays, read with tomllib alone."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tests.oracles.calculus import Array

TFLEX = Path(__file__).resolve().parents[2] / "machines" / "tflex.toml"


@dataclass(frozen=True)
class Body:
    """m [kg]; c (3,) [m] centre of mass; Ic (3, 3) [kg m2] about it, all in the body's frame."""

    m: float
    c: Array
    Ic: Array

    @property
    def J(self) -> Array:
        """Inertia (3, 3) [kg m2] about the frame's origin (Steiner)."""
        moment: Array = self.Ic + self.m * (self.c @ self.c * np.eye(3) - np.outer(self.c, self.c))
        return moment

    def with_point(self, m: float, c: Array) -> Body:
        """This body with a point mass m [kg] fixed at c (3,) [m]."""
        total = self.m + m
        centre = (self.m * self.c + m * c) / total
        J = self.J + m * (c @ c * np.eye(3) - np.outer(c, c))
        return Body(
            total, centre, J - total * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        )


@dataclass(frozen=True)
class Actuator:
    """[SH, Eq. (22)]: o, k, d, c (6,), a, b (6, n); sigma [rad], omega [1/rad]."""

    o: Array
    k: Array
    d: Array
    c: Array
    a: Array
    b: Array
    sigma: float
    omega: float


@dataclass(frozen=True)
class Machine:
    """Geometry in the world frame at the neutral pose, bodies, flexures, actuators.

    x_B, axis, u_B, r_EP (6, 3); k_u (2,), k_s (2,) [N m/rad]; J_rotor [kg m2].
    """

    g: Array
    L: float
    l: float  # noqa: E741 - the paper's neighbour of L
    x_E0: Array
    x_B: Array
    axis: Array
    u_B: Array
    r_EP: Array
    upper: Body
    J_rotor: float | Array
    lower: Body
    end_effector: Body
    c_payload: Array
    k_u: Array
    k_s: Array
    actuator: Actuator

    @property
    def R_B0(self) -> Array:
        """Upper-arm frames (6, 3, 3) at theta = 0: x along the arm, y the axis."""
        return np.stack([self.u_B, self.axis, np.cross(self.u_B, self.axis)], axis=-1)

    @property
    def R_Q0(self) -> Array:
        """Lower-arm frames (6, 3, 3) at neutral: x along the rod, y the axis made orthogonal."""
        rod = self.x_E0 + self.r_EP - self.x_B - self.L * self.u_B
        x = rod / np.linalg.norm(rod, axis=1, keepdims=True)
        y = self.axis - np.sum(self.axis * x, axis=1, keepdims=True) * x
        y = y / np.linalg.norm(y, axis=1, keepdims=True)
        return np.stack([x, y, np.cross(x, y)], axis=-1)

    def with_payload(self, m: float) -> Machine:
        """The machine that carries a point mass m [kg] at c_payload."""
        return replace(self, end_effector=self.end_effector.with_point(m, self.c_payload))


def read_machine(path: str | Path = TFLEX) -> Machine:
    """Read a machine file; every quantity is a table with `value`."""
    data = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    geometry, bodies, act = data["geometry"], data["bodies"], data["actuator"]
    arms = {key: np.array([_value(arm[key]) for arm in data["arms"]]) for key in data["arms"][0]}
    terms = {key: np.array(_value(act[key])) for key in "okdcab"}
    return Machine(
        g=np.array(_value(data["gravity"]["g"])),
        L=_value(geometry["L"]),
        l=_value(geometry["l"]),
        x_E0=np.array(_value(geometry["x_E0"])),
        **arms,
        upper=_body(bodies["upper"]),
        J_rotor=_value(bodies["upper"]["J_rotor"]),
        lower=_body(bodies["lower"]),
        end_effector=_body(bodies["end_effector"]),
        c_payload=np.array(_value(bodies["end_effector"]["c_payload"])),
        k_u=np.array(_value(data["flexures"]["k_u"])),
        k_s=np.array(_value(data["flexures"]["k_s"])),
        actuator=Actuator(**terms, sigma=_value(act["sigma"]), omega=_value(act["omega_cog"])),
    )


def _value(quantity: Any) -> Any:
    return quantity["value"]


def _body(table: Any) -> Body:
    xx, yy, zz, xy, xz, yz = _value(table["Ic"])
    Ic = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Body(_value(table["m"]), np.array(_value(table["c"])), Ic)

"""The hexapod as base model of the diagnosis: every arm's every parameter, not only the 162.

Arms that differ a little are no missing effect; the tolerances keep what the data cannot
determine at its nominal value.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from flexhex.diagnosis.basemodels.base import LATE, Geometry, Known, Motion, Stated
from flexhex.diagnosis.basemodels.closure import Closure, dahl_scan
from flexhex.diagnosis.basemodels.hexapod_geometry import geometry_of
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.bodies import (
    INERTIA_NAMES,
    Mechanism,
    mechanism_names,
    mechanism_units,
    nominal_mechanism,
    point_mass,
)
from flexhex.fmus.common.model.dynamics import loads, project
from flexhex.fmus.common.model.model import Model
from flexhex.fmus.common.model.parameters import actuator_parameters, base_parameters, term
from flexhex.numeric.rows import alike, native

Array = NDArray[np.float64]
CHUNK = 4000
"""Samples whose columns are held at a time."""


class HexapodBase:
    """Base model of a machine with or without its platform; see `Base`."""

    window, spacing, settle = 0.0105, 0.005, 1.0
    late = LATE
    holds = frozenset({"viscous_friction", "torque_offset", "linear_stiffness"})
    stated = Stated()
    rotors: tuple[int, ...] = ()
    complete = True

    def __init__(self, machine: Machine) -> None:
        self.machine, self.n, self.given = machine, machine.n_arms, machine.effects
        listed = _actuator(machine)
        self._kept = [k for k, known in enumerate(listed) if term(known.name) != "c"]
        self.linear = (*(listed[k] for k in self._kept), *_mechanism(machine))
        self.curved = tuple(known for known in listed if term(known.name) == "c")
        sigma, spread = machine.actuator.sigma, machine.tolerance.sigma * machine.actuator.sigma
        self.widths = tuple(
            Known(f"sigma[{i + 1}]", "rad", sigma, spread, f"sigma[{i + 1}]", i)
            for i in range(self.n)
        )
        names = [known.name for known in self.linear]
        carried = [f"end_effector.{name}" for name in INERTIA_NAMES if machine.has_platform]
        self.payload = tuple(names.index(name) for name in carried)
        self.reach = np.inf
        if machine.has_platform:
            self.reach = float(np.linalg.norm(machine.platform.r_EP, axis=1).max())
        self._build(len(listed))

    def _build(self, n_actuator: int) -> None:
        model = Model(self.machine)
        n, n_x = model.n, model.n_x
        x, xd, xdd = (ca.SX.sym(name, n_x) for name in ("x", "xd", "xdd"))
        linkage = model.linkage(x)
        par, g = ca.SX.sym("p", len(self.linear)), ca.SX.sym("g", 3)
        full = ca.SX.zeros(n_actuator)
        for place, k in enumerate(self._kept):
            full[k] = par[place]
        mechanism = Mechanism.split(par[len(self._kept) :], n)
        self._g, model.g = np.array(ca.DM(model.g), dtype=float).ravel(), g
        tau = project(linkage, loads(linkage, model.motion(xd, xdd), mechanism))
        tau += model.actuator_torque(full, x[:n], xd[:n], model.basis(x[:n], ca.SX.zeros(n)))
        Phi = ca.substitute(ca.jacobian(tau, par), g, ca.SX(self._g))
        sparsity = Phi.sparsity()
        self._at = np.array(sparsity.row()), np.array(sparsity.get_col())
        entries: Any = Phi.nonzeros()
        functions = [
            ca.Function("native_full", [x, xd, xdd], ca.cse([ca.vertcat(*entries)])),
            ca.Function("native_torque", [x, xd, xdd, par, g], ca.cse([tau])),
        ]
        self._full, self._torque = native(functions)
        self._closure, self._dahl = Closure(model), dahl_scan(n)
        self.geometry: Geometry | None = None
        if self.machine.has_platform and self.machine.tolerance.geometry:
            self.geometry = geometry_of(
                self.machine, self._solved, len(self._kept), len(self.linear)
            )

    def _solved(self, motion: Motion) -> tuple[Array, Array, Array]:
        """Coordinates (samples, n_x), joint rates and accelerations (samples, n)."""
        if self._closure not in motion.solved:
            motion.solved[self._closure] = self._closure.solve(motion.theta)
        return motion.solved[self._closure], motion.thetad, motion.thetadd

    def _states(self, motion: Motion) -> Iterator[tuple[slice, tuple[Array, Array, Array]]]:
        """Coordinates, rates and accelerations (`CHUNK`, n_x) of part after part of a motion."""
        x, thetad, thetadd = self._solved(motion)
        for at in range(0, len(x), CHUNK):
            part = slice(at, at + CHUNK)
            rates = self._closure.rates(x[part], thetad[part], thetadd[part])
            yield part, (x[part], *rates)

    def loaded(self, p: Array, payload: float) -> Array:
        """Parameters (n_p,) with a point mass `payload` [kg] at c_payload of E."""
        if payload == 0.0 or not self.machine.has_platform:
            return p
        return np.asarray(p + payload * self._point)

    @cached_property
    def _point(self) -> Array:
        """A kilogram at c_payload, as parameters (n_p,)."""
        point = np.zeros(len(self.linear))
        c = self.machine.platform.end_effector.c_payload
        ten = np.array(point_mass(1.0, c), dtype=float).ravel()
        point[list(self.payload)] = ten
        return point

    def rows(self, motion: Motion, weights: csr_array) -> Array:
        """Smoothed columns (rows, n, n_p), in chunks of samples."""
        size = weights.shape[0], self.n, len(self.linear)
        flat = np.zeros((size[0], len(self._at[0])))
        for part, state in self._states(motion):
            (values,) = self._full(*state)
            flat += weights[:, part] @ values
        dense = np.zeros(size)
        dense[:, self._at[0], self._at[1]] = flat
        return dense

    def bend(self, motion: Motion, widths: Array) -> tuple[Array, Array]:
        """Dahl states and their derivatives by sigma [1/rad], central differences."""
        step = 1e-3 * widths
        z, more, less = (
            self._dahl(np.zeros(self.n), motion.steady, sigma)
            for sigma in (widths, widths + step, widths - step)
        )
        return z, (more - less) / (2 * step)

    def torque(self, motion: Motion, p: Array) -> Array:
        """B p (samples, n) [N m]."""
        return self._under(motion, p, self._g)

    def whole(self, motion: Motion, p: Array) -> Mapping[str, Array]:
        """Tilted base: torque for a turn of a radian about the world's x and y."""
        g = self._g
        level = self._under(motion, p, g)
        columns = [self._under(motion, p, g + np.cross(g, axis)) - level for axis in np.eye(3)[:2]]
        return {"gravity_tilt": np.stack(columns, axis=2)}

    def _under(self, motion: Motion, p: Array, g: Array) -> Array:
        parts = []
        for _, state in self._states(motion):
            count = len(state[0])
            (tau,) = self._torque(*state, alike(p, count), alike(g, count))
            parts.append(tau)
        return np.concatenate(parts)


def _actuator(machine: Machine) -> list[Known]:
    """Torque terms, each known as well as its size, of a wave its amplitude. Where the file has
    zero there is no hysteresis and no wave; offset, stiffness and damping are not known."""
    pars = actuator_parameters(machine)
    values = dict(zip([par.name for par in pars], base_parameters(machine), strict=False))
    per, listed = len(pars) // machine.n_arms, []
    for k, par in enumerate(pars):
        kind, size = term(par.name), abs(values[par.name])
        if kind in "ab":
            pair = [values[re.sub(r"\.[ab]\[", f".{way}[", par.name)] for way in "ab"]
            size = float(np.hypot(*pair))
        spread = machine.tolerance.actuator * size if size or kind in "abc" else np.inf
        value = float(values[par.name])
        listed.append(Known(par.name, par.unit, value, spread, par.name, k // per))
    return listed


def _mechanism(machine: Machine) -> list[Known]:
    n, platform = machine.n_arms, machine.has_platform
    values = np.array(nominal_mechanism(machine).vector(), dtype=float).ravel()
    names, units = mechanism_names(n, platform), mechanism_units(n, platform)
    of = dict(zip(names, values, strict=True))
    listed = []
    for name, unit in zip(names, units, strict=True):
        body, _, entry = name.partition(".")
        kind = body.partition("[")[0]
        spread = _spread(machine, of, body, entry)
        listed.append(Known(name, unit, float(of[name]), spread, f"{kind}.{entry}"))
    return listed


def _spread(machine: Machine, of: Mapping[str, float], body: str, entry: str) -> float:
    """Tolerance of one entry of a body's inertia, or of a flexure's stiffness."""
    known, value = machine.tolerance, abs(of[f"{body}.{entry}"])
    if body.startswith("flexure"):
        return known.stiffness * value
    if entry == "m":
        return known.mass * value
    if entry.startswith("mc"):
        mass = of.get(f"{body}.m", machine.bodies.upper.m)
        length = max(machine.geometry.L, machine.geometry.l or 0.0)
        return float(np.hypot(known.mass * value, known.centre * length * mass))
    mean = sum(of.get(f"{body}.J_{a}{a}", 0.0) for a in "xyz") / 3
    # the share of the mean is that of principal axes which stand a little otherwise
    return float(known.inertia * np.hypot(value, mean))

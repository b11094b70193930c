"""Effects that the library knows by name (docs: fmus/common/effects/README.md), made with MuJoCo's
own means where there are any (native.py), or by a formula."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from studies.mujoco import native, swinging
from studies.mujoco.effect import Algebraic, Dahl, Effect, Late, Motion, Plain
from studies.mujoco.machine import Array
from studies.mujoco.place import Place

Rng = np.random.Generator
Axes = tuple[int, ...]
Maker = Callable[[Rng, Place], Effect]


def cogging(rng: Rng, place: Place, id: str = "cogging_harmonic") -> Effect:
    """A wave over the angle with up to two harmonics, of order 1 to 500 a turn or, along a line,
    some periods per stroke; no faster than the log can show."""
    fastest = float(np.quantile(np.abs(place.motion.v[:, list(place.axes)]), 0.95))
    low, high = 1.5 * np.pi / float(place.half.min()), 0.15 * 2 * np.pi * place.rate / fastest
    if place.machine.units[0] == "rad":
        low, high = max(low, 2.0), min(high, 500.0)
    order = float(np.exp(rng.uniform(np.log(low), np.log(max(high, low * 1.2)))))
    if place.machine.units[0] == "rad":
        order = float(max(2, round(order)))
    count = int(rng.integers(1, 4)) if 3 * order <= max(high, low) else 1
    height = np.array([1.0, *rng.uniform(0.1, 0.5, count - 1)])
    phase = rng.uniform(0, 2 * np.pi, (count, len(place.axes)))
    j = np.arange(1, count + 1)[:, None]
    ripple = id == "torque_ripple"

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        wave = (height[:, None] * np.cos(j * order * q + phase)).sum(axis=0)
        return np.asarray(wave * tau if ripple else wave)

    shapes = {
        "order": (order, f"1/{place.machine.units[0]}"),
        "harmonics": ([float(h) for h in height], "1"),
        "phase": ([[float(p) for p in row] for row in phase.T], "rad"),
    }
    unit = "1" if ripple else place.unit
    plain = Plain(id, form, "amplitude", unit, "drive" if ripple else "force", None, shapes)
    return Wave(plain, place.axes)


class Wave(Algebraic):
    """A single harmonic has the library's cosine and sine amplitudes as well."""

    def parameters(self, step: float) -> dict[str, Any]:
        rows = super().parameters(step)
        if len(self.shapes["harmonics"][0]) == 1:
            phase = np.array(self.shapes["phase"][0])[:, 0]
            for name, wave in (("a", np.cos(phase)), ("b", -np.sin(phase))):
                rows[name] = {"value": (self.gain * wave).tolist(), "unit": self.unit}
        return rows


def stribeck(rng: Rng, place: Place) -> Effect:
    """Friction that falls from rest on to a half or less: F_c (1 + s exp(-(v / v_s)^2)) sign v."""
    slow, peak = place.rms("v") * rng.uniform(0.05, 0.3), float(rng.uniform(0.5, 1.5))
    sharp = slow * 0.05

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.asarray((1 + peak * np.exp(-((v / slow) ** 2))) * np.tanh(v / sharp))

    shapes = {"F_s over F_c": (peak, "1"), "v_s": ([float(s) for s in slow], "per s")}
    plain = Plain("stribeck_friction", form, "F_c", place.unit, "force", None, shapes)
    return Algebraic(plain, place.axes)


def load_friction(rng: Rng, place: Place) -> Effect:
    sharp = place.rms("v") * 0.02

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.asarray(np.abs(tau) * np.tanh(v / sharp))

    return Algebraic(Plain("load_friction", form, "mu", "1", "drive"), place.axes)


def drag(rng: Rng, place: Place) -> Effect:
    plain = Plain("quadratic_drag", lambda t, q, v, tau: v * np.abs(v), "D_2", "per rate squared")
    return Algebraic(plain, place.axes)


def spring(power: int) -> Maker:
    """A spring of a power of the angle; a quadratic one grows to both sides alike."""

    def make(rng: Rng, place: Place) -> Effect:
        id, name = {
            2: ("quadratic_stiffness", "k_2"),
            3: ("cubic_stiffness", "k_3"),
        }[power]
        plain = Plain(id, lambda t, q, v, tau: q**power, name, "per position to a power")
        return Algebraic(plain, place.axes)

    return make


def offset(rng: Rng, place: Place) -> Effect:
    """The same torque at any time."""
    plain = Plain("torque_offset", lambda t, q, v, tau: np.ones(len(q)), "o", place.unit)
    return Algebraic(plain, place.axes)


def cable(rng: Rng, place: Place) -> Effect:
    """It pulls beyond an angle."""
    side = float(rng.choice([-1.0, 1.0]))
    begin = place.middle + side * place.half * rng.uniform(0.0, 0.5)

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.asarray(side * np.maximum(0.0, side * (q - begin)))

    shapes = {"theta_0": ([float(b) for b in begin], "position"), "side": (side, "1")}
    plain = Plain("cable_force", form, "k_c", "per position", "force", None, shapes)
    return Algebraic(plain, place.axes)


def hysteresis(rng: Rng, place: Place) -> Effect:
    return Dahl("second_hysteresis", place.axes, place.half * rng.uniform(0.05, 0.3), place.unit)


def drift(rng: Rng, place: Place) -> Effect:
    """A torque that creeps in during every run."""
    time = float(place.motion.t[-1] * rng.uniform(0.3, 2.0))

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.full(len(q), time * (1 - np.exp(-t / time)))

    plain = Plain("offset_drift", form, "o_r", "per s", "force", None, {"T": (time, "s")})
    return Algebraic(plain, place.axes)


def warm(rng: Rng, place: Place) -> Effect:
    """The torque constant falls during every run."""
    time = float(place.motion.t[-1] * rng.uniform(0.3, 1.5))

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.asarray(tau * (1 - np.exp(-t / time)))

    return Algebraic(
        Plain("thermal_drift", form, "g_t", "1", "drive", None, {"T": (time, "s")}), place.axes
    )


def iron(rng: Rng, place: Place) -> Effect:
    """Torque falls behind the current beyond a corner."""
    corner = place.rms("tau") * rng.uniform(0.3, 1.2)

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.asarray(tau * np.maximum(0.0, np.abs(tau) - corner))

    shapes = {"tau_k": ([float(c) for c in corner], place.unit)}
    plain = Plain("torque_constant_saturation", form, "s", "per torque", "drive", None, shapes)
    return Algebraic(plain, place.axes)


def eccentric(rng: Rng, place: Place) -> Effect:
    """The encoder reads `gain sin(k q + phase)` too much, k = 1, 2 or 4 a turn."""
    order, phase = float(rng.choice([1, 1, 2, 4])), float(rng.uniform(0, 2 * np.pi))

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.asarray(np.sin(order * q + phase))

    shapes = {"order": (order, "1/rad"), "phase": (phase, "rad")}
    plain = Plain("encoder_eccentricity", form, "e", "rad", "reading", None, shapes)
    return Eccentric(plain, place.axes)


class Eccentric(Algebraic):
    """Sized by the acceleration that is misread, with the inertia that the axis feels."""

    def size(self, motion: Motion, share: float) -> None:
        pick, order = list(self.axes), float(self.shapes["order"][0])
        a, v = motion.a[:, pick], motion.v[:, pick]
        felt = np.sqrt(np.mean((order * a) ** 2 + (order**2 * v * v) ** 2, axis=0))
        inertia = motion.rms()[pick] / np.maximum(np.sqrt(np.mean(a**2, axis=0)), 1e-300)
        gain = share * motion.rms()[pick] / np.maximum(felt * inertia, 1e-300)
        self.gain = np.minimum(gain, 0.3 / order)


def late(rng: Rng, place: Place) -> Effect:
    return Late(place.axes, 1.0 / place.rate)


MAKERS: Mapping[str, Maker] = {
    "coulomb_friction": native.coulomb,
    "viscous_friction": native.viscous,
    "flexible_mode": swinging.mode,
    "drive_lag": native.lag,
    "drive_gain": native.gain,
    "torque_saturation": native.limit,
    "gravity_tilt": native.tilt,
    "cogging_harmonic": cogging,
    "torque_ripple": lambda rng, place: cogging(rng, place, "torque_ripple"),
    "stribeck_friction": stribeck,
    "load_friction": load_friction,
    "quadratic_drag": drag,
    "quadratic_stiffness": spring(2),
    "cubic_stiffness": spring(3),
    "cable_force": cable,
    "second_hysteresis": hysteresis,
    "offset_drift": drift,
    "thermal_drift": warm,
    "torque_constant_saturation": iron,
    "encoder_eccentricity": eccentric,
    "cross_coupling": native.coupling,
    "time_delay": late,
    "torque_offset": offset,
    "linear_stiffness": native.spring,
}

"""Effects by MuJoCo's own means: friction loss, damping, bodies on springs, actuator dynamics,
force range, gear, tendons, direction of gravity."""

from __future__ import annotations

from typing import Any

import numpy as np

from studies.mujoco.effect import Effect, Motion
from studies.mujoco.machine import Array, G, Link, Machine, Parts, full
from studies.mujoco.place import Place

Rng = np.random.Generator


class Joint(Effect):
    """An attribute of MuJoCo's joints whose torque is `gain * unit`."""

    place = "model"
    attribute = ""

    def change(self, parts: Parts, machine: Machine) -> None:
        for axis, gain in zip(self.axes, self.gain, strict=True):
            own = parts.joint.setdefault(axis, {})
            own[self.attribute] = own.get(self.attribute, 0.0) + float(gain)


class Coulomb(Joint):
    """Friction loss."""

    attribute = "frictionloss"

    def at(self, t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.asarray(np.sign(v))


class Spring(Joint):
    """A spring in the joint, at rest at an angle or a position of each axis."""

    attribute = "stiffness"

    def __init__(self, axes: tuple[int, ...], rest: Array):
        super().__init__("linear_stiffness", axes)
        self.rest, self.parameter, self.unit = rest, "k_1", "per position"

    def at(self, t: float, q: Array, v: Array, tau: Array) -> Array:
        return q - self.rest

    def change(self, parts: Parts, machine: Machine) -> None:
        super().change(parts, machine)
        for axis, rest in zip(self.axes, self.rest, strict=True):
            parts.joint[axis]["springref"] = float(rest)


class Viscous(Joint):
    """Damping."""

    attribute = "damping"

    def at(self, t: float, q: Array, v: Array, tau: Array) -> Array:
        return v


def coulomb(rng: Rng, place: Place) -> Effect:
    """Dry friction."""
    effect = Coulomb("coulomb_friction", place.axes)
    effect.parameter, effect.unit = "F_c", place.unit
    return effect


def viscous(rng: Rng, place: Place) -> Effect:
    """Viscous friction."""
    effect = Viscous("viscous_friction", place.axes)
    effect.parameter, effect.unit = "d_v", "per rate"
    return effect


def spring(rng: Rng, place: Place) -> Effect:
    """A spring that is at rest within the stroke or some way beyond it."""
    return Spring(place.axes, place.middle + place.half * rng.uniform(-2.0, 2.0, len(place.axes)))


def felt(link: Link) -> float:
    """Inertia or mass of a link and its rotor about their own axis."""
    if link.joint == "slide":
        return link.mass + link.armature
    c = link.centre
    return float(full(link.inertia)[2, 2] + link.mass * (c[0] ** 2 + c[1] ** 2) + link.armature)


class Motor(Effect):
    """A setting of MuJoCo's actuators."""

    place = "model"

    def change(self, parts: Parts, machine: Machine) -> None:
        for axis, gain in zip(self.axes, self.gain, strict=True):
            parts.motor.setdefault(axis, {}).update(self.setting(float(gain)))

    def setting(self, gain: float) -> dict[str, str]:
        """Attributes of one motor."""
        raise NotImplementedError


class Lag(Motor):
    """First-order actuator dynamics."""

    def along(self, motion: Motion) -> Array:
        step = float(motion.t[1] - motion.t[0])
        return np.asarray(np.gradient(motion.tau[:, list(self.axes)], step, axis=0))

    def setting(self, gain: float) -> dict[str, str]:
        return {"dyntype": "filterexact", "dynprm": f"{gain:.9g}"}

    def parameters(self, step: float) -> dict[str, Any]:
        """MuJoCo applies its filter's state of the step before: the mean lag is
        step / (1 - exp(-step / T)), about half a step more than T."""
        lag = step / -np.expm1(-step / self.gain)
        return {"T_lag": {"value": lag.tolist(), "unit": "s"}}


class Gain(Motor):
    """The joint gets less of every torque."""

    def at(self, t: float, q: Array, v: Array, tau: Array) -> Array:
        return tau

    def setting(self, gain: float) -> dict[str, str]:
        return {"gainprm": f"{1 - gain:.12g}"}


class Limit(Motor):
    """Force range: the joint gets no more than the limit, whatever is reported."""

    def size(self, motion: Motion, share: float) -> None:
        tau = np.abs(motion.tau[:, list(self.axes)])
        # the feedback asks for more as soon as the joint gets less
        top, lost = tau.max(axis=0), 0.3 * share * motion.rms()[list(self.axes)]
        grid = np.linspace(0.999, 0.4, 300)[:, None] * top
        over = [np.sqrt(np.mean(np.maximum(0, tau - g) ** 2, axis=0)) for g in grid]
        best = np.argmin(np.abs(np.array(over) - lost), axis=0)
        self.gain = grid[best, range(len(self.axes))]

    def setting(self, gain: float) -> dict[str, str]:
        return {"forcerange": f"{-gain:.12g} {gain:.12g}"}


def lag(rng: Rng, place: Place) -> Effect:
    """A drive that follows its command late."""
    effect = Lag("drive_lag", place.axes)
    effect.parameter, effect.unit = "T_lag", "s"
    return effect


def gain(rng: Rng, place: Place) -> Effect:
    """A torque constant that is smaller than the drive believes."""
    effect = Gain("drive_gain", place.axes)
    effect.parameter = "g"
    return effect


def limit(rng: Rng, place: Place) -> Effect:
    """A torque limit that the report does not show."""
    effect = Limit("torque_saturation", place.axes)
    effect.parameter, effect.unit = "tau_lim", place.unit
    return effect


class Tilt(Effect):
    """Gravity points elsewhere."""

    place = "model"

    def __init__(self, axes: tuple[int, ...], direction: float):
        # arms have gravity's direction among their parameters
        super().__init__("gravity_tilt", axes, ("gravity_tilt", "gravity."))
        self.direction, self.angle = direction, 0.0

    def size(self, motion: Motion, share: float) -> None:
        self.angle = float(np.clip(2 * share, 0.002, 0.3))
        self.gain = np.array([self.angle])

    def change(self, parts: Parts, machine: Machine) -> None:
        s, c = np.sin(self.angle), np.cos(self.angle)
        x, y = np.cos(self.direction), np.sin(self.direction)
        parts.gravity = (G * s * x, G * s * y, -G * c)

    def parameters(self, step: float) -> dict[str, Any]:
        x, y = np.cos(self.direction), np.sin(self.direction)
        return {
            "tilt_x": {"value": self.angle * y, "unit": "rad"},
            "tilt_y": {"value": -self.angle * x, "unit": "rad"},
        }


def tilt(rng: Rng, place: Place) -> Effect:
    """A base that does not stand level; it acts on all axes."""
    return Tilt(tuple(range(place.machine.n)), float(rng.uniform(0, 2 * np.pi)))


class Crosstalk(Effect):
    """A drive reports a share of another drive's torque as well."""

    place, whole = "drive", True

    def __init__(self, axes: tuple[int, ...], source: int):
        super().__init__("cross_coupling", axes)
        self.source, self.parameter = source, "C"
        self.shapes = {"source": (source + 1, "axis"), "kind": (3, "torque")}

    def at(self, t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.full(len(self.axes), tau[self.source])


class Cable(Effect):
    """A tendon spring between two neighbours."""

    place = "model"

    def __init__(self, axes: tuple[int, int], sign: float):
        super().__init__("cross_coupling", axes)
        self.sign, self.parameter, self.unit = sign, "C", "per position"
        self.shapes = {"kind": (0, "angle")}

    def along(self, motion: Motion) -> Array:
        one, two = (motion.q[:, [k]] - motion.q[0, k] for k in self.axes)
        pull = one + self.sign * two
        return np.concatenate([pull, self.sign * pull], axis=1)

    def size(self, motion: Motion, share: float) -> None:
        super().size(motion, share)
        self.gain = np.full(2, float(self.gain.min()))

    def change(self, parts: Parts, machine: Machine) -> None:
        one, two = (k + 1 for k in self.axes)
        parts.tendons += (
            f'<fixed stiffness="{self.gain[0]:.12g}" springlength="0"><joint joint="j{one}"'
            f' coef="1"/><joint joint="j{two}" coef="{self.sign}"/></fixed>'
        )


def coupling(rng: Rng, place: Place) -> Effect:
    """A cable between linear axes, crosstalk of drives elsewhere."""
    n, first = place.machine.n, place.axes[0]
    other = int((first + rng.integers(1, n)) % n)
    if place.machine.kind == "gantry":
        pair = (min(first, other), max(first, other))
        return Cable(pair, float(rng.choice([-1.0, 1.0])))
    return Crosstalk((first,), other)

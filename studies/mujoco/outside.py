"""Things that no list of effects has, but for one; a verdict should say that something is there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from studies.mujoco import swinging
from studies.mujoco.effect import Algebraic, Effect, Motion, Plain
from studies.mujoco.machine import Array, Machine, Parts, numbers
from studies.mujoco.place import Place

Rng = np.random.Generator


def _spot(rng: Rng, place: Place) -> tuple[Array, Array]:
    """Where (axes,) and how wide (axes,)."""
    at = place.middle + place.half * rng.uniform(-0.6, 0.6)
    return at, place.half * float(rng.uniform(0.05, 0.2))


def _effect(id: str, form: Callable[..., Array], place: Place, where: str, **shapes: Any) -> Effect:
    listed = {name: (np.asarray(value).tolist(), "SI") for name, value in shapes.items()}
    return Algebraic(Plain(id, form, "gain", "SI", where, (), listed), place.axes)


def friction_patch(rng: Rng, place: Place) -> Effect:
    """Dry friction about one angle only."""
    (at, wide), sharp = _spot(rng, place), place.rms("v") * 0.02

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.asarray(np.tanh(v / sharp) * np.exp(-(((q - at) / wide) ** 2)))

    return _effect("friction_patch", form, place, "force", at=at, width=wide)


def bump(rng: Rng, place: Place) -> Effect:
    """A dent."""
    at, wide = _spot(rng, place)

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.asarray(np.exp(-(((q - at) / wide) ** 2)))

    return _effect("bump", form, place, "force", at=at, width=wide)


def magnet(rng: Rng, place: Place) -> Effect:
    """A magnet that draws to an angle, x / (1 + x^2)^2."""
    at, wide = _spot(rng, place)

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        x = (q - at) / wide
        return np.asarray(x / (1 + x * x) ** 2)

    return _effect("magnet_spring", form, place, "force", at=at, width=wide)


def one_way(rng: Rng, place: Place) -> Effect:
    """Gear losses of one direction of the power only: |tau| where the load drives the motor.

    As |tau| sign(v) [tau v < 0] = (|tau| sign(v) - tau) / 2, it is load-dependent friction of half
    the size beside an error of the torque constant: the name that is right.
    """
    sharp = place.rms("v") * 0.02

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.asarray(np.abs(tau) * np.where(tau * v < 0, np.tanh(v / sharp), 0.0))

    plain = Plain("one_way_load_friction", form, "gain", "SI", "drive", ("load_friction",))
    return Algebraic(plain, place.axes)


def switching(rng: Rng, place: Place) -> Effect:
    """A brake that drags in two stretches of every run."""
    end = float(place.motion.t[-1])
    times = np.sort(rng.uniform(0.1, 0.9, 4)) * end
    sharp = place.rms("v") * 0.02

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        on = times[0] < t < times[1] or times[2] < t < times[3]
        return np.asarray(np.tanh(v / sharp) * float(on))

    return _effect("switching_brake", form, place, "force", times=times)


def dead_zone(rng: Rng, place: Place) -> Effect:
    """A drive that does nothing for small commands; its width is the gain."""
    effect = DeadZone("dead_zone", place.axes, ())
    effect.parameter, effect.unit = "width", place.unit
    return effect


class DeadZone(Effect):
    """The joint gets sign(tau) max(0, |tau| - gain)."""

    place = "drive"

    def at(self, t: float, q: Array, v: Array, tau: Array) -> Array:
        width = np.where(self.gain > 0, self.gain, 1.0)
        return np.asarray(np.clip(tau, -width, width) / width)

    def along(self, motion: Motion) -> Array:
        return np.asarray(np.sign(motion.tau[:, list(self.axes)]))


def pose_damping(rng: Rng, place: Place) -> Effect:
    """Damping that depends on the angle."""
    k, middle = rng.uniform(0.8, 1.6) / place.half, place.middle

    def form(t: float, q: Array, v: Array, tau: Array) -> Array:
        return np.asarray(v * np.sin(k * (q - middle)))

    return _effect("pose_damping", form, place, "force", k=k, middle=middle)


class Elastic(Effect):
    """The motor drives the joint through a spring; the encoder sits on the joint."""

    place = "model"

    def __init__(self, axes: tuple[int, ...], f: float, zeta: float, rotor: Array):
        super().__init__("noncollocated_mode", axes, ())
        self.f, self.zeta, self.rotor = f, zeta, rotor
        self.parameter, self.unit = "J_rotor", "kg m2 or kg"
        self.shapes = {"f": (f, "Hz"), "zeta": (zeta, "1")}

    def size(self, motion: Motion, share: float) -> None:
        """The rotor is as it is; the frequency makes the size: J a'' / w^2 beside the torque."""
        step = float(motion.t[1] - motion.t[0])
        a = motion.a[:, list(self.axes)]
        jerk = np.gradient(np.gradient(a, step, axis=0), step, axis=0)[20:-20]
        rms = np.sqrt(np.mean(jerk**2, axis=0)) * self.rotor
        w = float(np.sqrt(np.max(rms / (share * motion.rms()[list(self.axes)]))))
        self.f = float(np.clip(w / (2 * np.pi), self.f, 4 * self.f))
        self.shapes["f"] = (self.f, "Hz")
        self.gain = self.rotor.copy()

    def change(self, parts: Parts, machine: Machine) -> None:
        w = 2 * np.pi * self.f
        for axis, J in zip(self.axes, self.rotor, strict=True):
            link = machine.links[axis]
            own = parts.joint.setdefault(axis, {})
            own["armature"] = own.get("armature", link.armature) - float(J)
            # a rotor beside the arm, with the joint's start as its own zero
            parts.world += (
                f'<body name="x{axis + 1}"><joint name="x{axis + 1}" type="{link.joint}"'
                f' axis="0 0 1" armature="{J:.12g}"/><inertial mass="{1e-6 * link.mass:.9g}"'
                f' pos="0 0 0" diaginertia="{numbers(np.ones(3) * 1e-4 * J)}"/></body>'
            )
            parts.tendons += (
                f'<fixed stiffness="{J * w * w:.12g}" damping="{2 * self.zeta * w * J:.12g}"'
                f' springlength="0"><joint joint="j{axis + 1}" coef="-1"/>'
                f'<joint joint="x{axis + 1}" coef="1"/></fixed>'
            )
            parts.motor.setdefault(axis, {})["joint"] = f"x{axis + 1}"


def noncollocated(rng: Rng, place: Place) -> Effect:
    """A rotor behind a spring."""
    f = float(min(15 * place.machine.frequency, 0.15 * place.rate))
    rotor = np.array([0.5 * place.machine.links[k].armature for k in place.axes])
    return Elastic(place.axes, f, float(rng.uniform(0.15, 0.3)), rotor)


MAKERS: Mapping[str, Callable[[Rng, Place], Effect]] = {
    "friction_patch": friction_patch,
    "bump": bump,
    "magnet_spring": magnet,
    "one_way_load_friction": one_way,
    "switching_brake": switching,
    "dead_zone": dead_zone,
    "pose_damping": pose_damping,
    "noncollocated_mode": noncollocated,
    "backlash": swinging.backlash,
}

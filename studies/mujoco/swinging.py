"""A part of a rotor that hangs on a spring or rattles in a gap: a body in MuJoCo's model."""

from __future__ import annotations

import numpy as np

from studies.mujoco.effect import Effect, Motion
from studies.mujoco.machine import Array, Machine, Parts, numbers
from studies.mujoco.place import Place

Rng = np.random.Generator


class Swinging(Effect):
    """A part of the rotor hangs on a spring (`play` 0), or rattles in a gap (`play` > 0)."""

    place = "model"

    def __init__(self, id: str, axes: tuple[int, ...], f: float, zeta: float, play: float = 0.0):
        super().__init__(id, axes, (id,) if play == 0 else ())
        self.f, self.zeta, self.play = f, zeta, play
        self.parameter, self.unit = "J_2", "kg m2 or kg"
        self.shapes = {"f": (f, "Hz"), "zeta": (zeta, "1")}
        if play:
            self.shapes["play"] = (play, "position")
        self.most = np.zeros(len(axes))

    def along(self, motion: Motion) -> Array:
        """Torque of a unit of inertia that swings: s^2 / (s^2 + 2 zeta w s + w^2) a."""
        step, w = float(motion.t[1] - motion.t[0]), 2 * np.pi * self.f
        a = motion.a[:, list(self.axes)]
        s = 2j * np.pi * np.fft.rfftfreq(2 * len(a), step)[:, None]
        share = s * s / (s * s + 2 * self.zeta * w * s + w * w)
        spectrum = np.fft.rfft(a, 2 * len(a), axis=0)
        return np.asarray(np.fft.irfft(spectrum * share, 2 * len(a), axis=0)[: len(a)])

    def size(self, motion: Motion, share: float) -> None:
        super().size(motion, share)
        self.gain = np.minimum(self.gain, self.most)

    def change(self, parts: Parts, machine: Machine) -> None:
        w = 2 * np.pi * self.f
        for axis, J in zip(self.axes, self.gain, strict=True):
            link = machine.links[axis]
            own = parts.joint.setdefault(axis, {})
            own["armature"] = own.get("armature", link.armature) - float(J)
            if self.play:
                limits = f'range="{-self.play:.9g} {self.play:.9g}" damping="{J * w * 0.01:.9g}"'
            else:
                limits = f'stiffness="{J * w * w:.12g}" damping="{2 * self.zeta * w * J:.12g}"'
            turns = link.joint == "hinge"
            mass = link.mass * 1e-6 if turns else J
            inner = J * np.array([0.55, 0.55, 1.0]) if turns else J * np.ones(3) * 1e-6
            parts.bodies[axis] = parts.bodies.get(axis, "") + (
                f'<body name="x{axis + 1}"><joint name="x{axis + 1}" type="{link.joint}"'
                f' axis="0 0 1" {limits}/><inertial mass="{mass:.12g}" pos="0 0 0"'
                f' diaginertia="{numbers(inner)}"/></body>'
            )


def _frequency(rng: Rng, place: Place) -> float:
    """Well above the motion, well below what the log shows."""
    slow = place.machine.frequency
    high = min(30 * slow, 0.15 * place.rate)
    # of a fast motion in a slow log, where the log would show no more
    low = min(6 * slow, high / 2)
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def mode(rng: Rng, place: Place) -> Effect:
    """A part of the rotor on a spring."""
    zeta = float(10 ** rng.uniform(-2, -0.7))
    effect = Swinging("flexible_mode", place.axes, _frequency(rng, place), zeta)
    effect.most = np.array([0.8 * place.machine.links[k].armature for k in place.axes])
    return effect


def backlash(rng: Rng, place: Place) -> Effect:
    """A part of the rotor in a gap."""
    play = float(place.half.min() * 10 ** rng.uniform(-2.5, -1.2))
    effect = Swinging("backlash", place.axes, _frequency(rng, place), 0.1, play)
    effect.most = np.array([0.8 * place.machine.links[k].armature for k in place.axes])
    return effect

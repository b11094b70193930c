"""The closed loop: MuJoCo's machine under a PD or PID controller, recorded at the log's rate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.signal import lfilter

from studies.mujoco import hexapod
from studies.mujoco.case import Case
from studies.mujoco.effect import Effect
from studies.mujoco.machine import Array
from studies.mujoco.model import compiled, inverse, places
from studies.mujoco.motion import Reference, reference

STEADY = 0.1
"""Largest bandwidth times step of the loop."""


class UnstableLoopError(ValueError):
    """The loop did not follow its reference."""


@dataclass(frozen=True)
class Record:
    """A run at the log's rate: time (samples,) [s]; q, v, a of all joints of the model (samples,
    n_v); r, u (motor torque that is reported), force (of MuJoCo's actuators), disturbance (samples,
    n); parts: what each formula asked for (samples, axes), None where it is in the model."""

    t: Array
    r: Array
    q: Array
    v: Array
    a: Array
    u: Array
    ctrl: Array
    force: Array
    applied: Array
    disturbance: Array
    parts: tuple[Array | None, ...]
    at: Array
    """Where the axes stand among the n_v."""

    def misread(self, effects: Sequence[Effect]) -> Array:
        """What the encoders read beside the positions (samples, n)."""
        out = np.zeros_like(self.u)
        for effect, part in zip(effects, self.parts, strict=True):
            if effect.place == "reading" and part is not None:
                out += part
        return out


@dataclass(frozen=True)
class Plant:
    """What is common to the runs of a case: model with its effects, feedback gains (n,)."""

    case: Case
    model: mujoco.MjModel
    effects: tuple[Effect, ...]
    gains: tuple[Array, Array, Array]
    scale: Array
    """Torque RMS (n,) that disturbances are relative to."""


def gains_of(case: Case) -> tuple[Array, Array, Array]:
    """Proportional, derivative and integral gains (n,) from the diagonal of the mass matrix."""
    model = compiled(case.machine, case.step, ())
    data = mujoco.MjData(model)
    if case.machine.chain is None:
        data.qpos[:] = case.machine.middle
    mujoco.mj_forward(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    if model.neq:
        (V,) = hexapod.projections(model, data.qpos[None], places(model, case.machine.n))
        M = V.T @ M @ V
    w = min(case.loop.bandwidth * 2 * np.pi * case.machine.frequency, STEADY / case.step)
    kp = np.diag(M) * w * w
    return kp, np.diag(M) * 1.6 * w, kp * 0.15 * w * float(case.loop.integral)


def feedforward(case: Case, ref: Reference) -> Array:
    """Torque (samples, n) that the machine file's model wants along the reference."""
    n, kind = case.machine.n, case.loop.feedforward
    if kind == "none":
        return np.zeros((len(ref.r), n))
    model = compiled(case.written, case.step, ())
    thin = max(1, len(ref.r) // 4000)
    some = np.arange(0, len(ref.r), thin)
    still = kind == "gravity"
    v, a = (0 * x[some] if still else x[some] for x in (ref.rd, ref.rdd))
    tau = inverse(model, ref.r[some], v, a)
    at = np.arange(len(ref.r))
    return np.stack([np.interp(at, some, tau[:, k]) for k in range(n)], axis=1)


def coloured(rng: np.random.Generator, shape: tuple[int, int], corner: float) -> Array:
    """Noise of RMS 1 below a corner, relative to the sample rate."""
    pole = np.exp(-2 * np.pi * corner)
    raw = rng.standard_normal((shape[0] + round(min(3 / corner, 20000)), shape[1]))
    filtered = lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], raw, axis=0)
    return np.asarray(filtered[-shape[0] :])


def run(plant: Plant, trajectory: tuple[str, int], seed: int) -> Record:
    """One run; `seed` is that of its disturbance. UnstableLoopError when it runs away."""
    case, n = plant.case, plant.case.machine.n
    ref = reference(*trajectory, case.machine, case.seconds, case.step)
    count = len(ref.r)
    rng = np.random.default_rng([case.noise.seed, seed, 3])
    noise = coloured(rng, (count, n), case.noise.corner * case.step)
    noise *= case.noise.disturbance * plant.scale
    return _integrate(plant, ref, feedforward(case, ref), noise)


def _integrate(plant: Plant, ref: Reference, ff: Array, noise: Array) -> Record:
    case, model, step = plant.case, plant.model, plant.case.step
    n, every = case.machine.n, case.substeps
    data, at = mujoco.MjData(model), places(model, n)
    _begin(model, data, ref, n)
    law = _Law(plant)
    qpos, qvel, qacc = data.qpos, data.qvel, data.qacc
    ctrl, applied, force = data.ctrl, data.qfrc_applied, data.actuator_force
    rows: list[tuple[Array, ...]] = []
    limit = 3 * np.max(case.machine.reach) + 1e-9
    for k in range(len(ref.r)):
        q, v = qpos[at], qvel[at]
        u, ctrl[:], more = law.torque(k * step, q, v, (ref.r[k], ref.rd[k], ff[k]))
        more += noise[k]
        applied[at] = more
        if k % every:
            mujoco.mj_step(model, data)
            continue
        before = qpos.copy(), qvel.copy()
        mujoco.mj_step(model, data)
        rows.append((*before, qacc.copy(), u, ctrl.copy(), force.copy(), more))
        law.keep()
        if not np.abs(ref.r[k] - q).max() < limit:
            where = f"at {q}, not {ref.r[k]}, after {k * step:.3f} s"
            raise UnstableLoopError(f"seed {case.seed}: {where}")
    names = ("q", "v", "a", "u", "ctrl", "force", "applied")
    columns = {x: np.array(c) for x, c in zip(names, zip(*rows, strict=True), strict=True)}
    some = slice(None, None, every)
    time = np.arange(len(rows)) / case.rate
    return Record(time, ref.r[some], **columns, disturbance=noise[some], parts=law.parts(), at=at)


class _Law:
    """Controller and formulas of the effects, step by step."""

    def __init__(self, plant: Plant) -> None:
        self.plant, self.n, self.step = plant, plant.case.machine.n, plant.case.step
        self.total = np.zeros(self.n)
        for effect in plant.effects:
            effect.reset(self.step)
        formulas = [(e, list(e.axes)) for e in plant.effects if e.place != "model"]
        self.readings = [pair for pair in formulas if pair[0].place == "reading"]
        self.losses = [pair for pair in formulas if pair[0].place != "reading"]
        self.now: dict[int, Array] = {}
        self.kept: dict[int, list[Array]] = {id(e): [] for e, _ in formulas}

    def torque(
        self, t: float, q: Array, v: Array, goal: tuple[Array, Array, Array]
    ) -> tuple[Array, Array, Array]:
        """Reported torque, what reaches the actuator, what acts on the joints beside it (n,)."""
        seen, (kp, kd, ki) = q, self.plant.gains
        for effect, axes in self.readings:
            wrong = np.zeros(self.n)
            wrong[axes] = effect.gain * effect.at(t, q[axes], v[axes], v[axes])
            seen, self.now[id(effect)] = seen + wrong, wrong
        error = goal[0] - seen
        self.total += error * self.step
        u = goal[2] + kp * error + kd * (goal[1] - v) + ki * self.total
        ctrl, more = u.copy(), np.zeros(self.n)
        for effect, axes in self.losses:
            own = (q, v, u) if effect.whole else (q[axes], v[axes], u[axes])
            part = effect.gain * effect.at(t, *own)
            (ctrl if effect.place == "drive" else more)[axes] -= part
            self.now[id(effect)] = part
        return u, ctrl, more

    def keep(self) -> None:
        """Record the parts of this instant."""
        for number, part in self.now.items():
            self.kept[number].append(part)

    def parts(self) -> tuple[Array | None, ...]:
        """What each effect asked for (samples, axes), a reading's (samples, n)."""
        return tuple(
            np.array(self.kept[id(e)]) if e.place != "model" else None for e in self.plant.effects
        )


def _begin(model: mujoco.MjModel, data: mujoco.MjData, ref: Reference, n: int) -> None:
    for k in range(n):
        data.qpos[model.joint(f"j{k + 1}").qposadr[0]] = ref.r[0, k]
        data.qvel[model.joint(f"j{k + 1}").dofadr[0]] = ref.rd[0, k]
    for number in range(model.njnt):
        name = model.joint(number).name
        body = model.body(model.jnt_bodyid[number])
        if name.startswith("x") and model.body_parentid[body.id] == 0:
            # a rotor beside the arm starts where its joint does
            data.qpos[model.jnt_qposadr[number]] = ref.r[0, int(name[1:]) - 1]

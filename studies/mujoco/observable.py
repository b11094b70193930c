"""How much of an effect a fit of the base model's own parameters leaves, with MuJoCo's columns."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np
from scipy.optimize import lsq_linear

from studies.mujoco.case import Case
from studies.mujoco.effect import Effect
from studies.mujoco.hexapod import projections
from studies.mujoco.machine import Array
from studies.mujoco.model import compiled, inverse, places
from studies.mujoco.native import Motor
from studies.mujoco.simulate import Record

ROWS = 600
"""Instants of a run that are used."""
NUDGE = 1e-4
State = tuple[Array, Array, Array, Array | None]


def contribution(case: Case, effects: Sequence[Effect], k: int, record: Record) -> Array:
    """Torque (samples, n) that is reported on account of effect k and of nothing else."""
    effect, n = effects[k], case.machine.n
    out = np.zeros((len(record.q), n))
    part = record.parts[k]
    rest = [e for j, e in enumerate(effects) if j != k]
    if effect.place in ("force", "drive"):
        out[:, list(effect.axes)] = part
    elif effect.place == "reading":
        assert part is not None
        out = _misread(case, record, part)
    elif isinstance(effect, Motor):
        out[:, list(effect.axes)] = (record.ctrl - record.force)[:, list(effect.axes)]
    else:
        # what moves the joints, less what the same motion takes without the effect
        with_it = compiled(case.machine, case.step, effects)
        model = compiled(case.machine, case.step, rest)
        pick: list[int] | slice = slice(None)
        if model.nv < record.v.shape[1]:
            pick = [_dof(with_it, model.joint(j).name) for j in range(model.njnt)]
        wanted = inverse(model, *(x[:, pick] for x in (record.q, record.v, record.a)))
        out = record.force + record.applied - wanted[:, places(model, n)]
    return out


def _dof(model: mujoco.MjModel, name: str) -> int:
    return int(model.joint(name).dofadr[0])


def _misread(case: Case, record: Record, part: Array) -> Array:
    """Rigid torque along the true motion less that along the motion that is read."""
    model = compiled(case.machine, case.step, ())
    q, v, a = (x[:, record.at] for x in (record.q, record.v, record.a))
    step = 1 / case.rate
    rate = np.gradient(part, step, axis=0)
    bent = inverse(model, q + part, v + rate, a + np.gradient(rate, step, axis=0))
    return np.asarray(inverse(model, q, v, a) - bent)


def columns(case: Case, record: Record, friction: bool) -> tuple[Array, list[str]]:
    """Columns (samples, n, columns) of the base model along a run, and what they stand for.

    Ten parameters of each body (tangents: mass, centre, inertia), rotors, a common delay; offsets,
    rates and positions for machines whose base model has them, damping and springs;
    `friction`: signs of the rates, and the rates, for all.
    """
    model, n = compiled(case.machine, case.step, ()), case.machine.n
    q, v, a = (x[:, record.at] for x in (record.q, record.v, record.a))
    state: State = (q, v, a, None)
    if model.neq:
        state = (record.q, record.v, record.a, projections(model, record.q, record.at))
    listed, names = _bodies(model, state, places(model, n))
    one = np.eye(n)
    names.append("delay")
    listed.append(np.gradient(record.u, 1 / case.rate, axis=0))
    signals = {"rotor": a}
    if case.machine.kind != "arm":
        signals |= {"offset": np.ones_like(a), "damping": v, "spring": q}
    if friction:
        sharp = 0.01 * np.sqrt(np.mean(v**2, axis=0))
        signals |= {"viscous": v, "coulomb": np.tanh(v / sharp)}
    for name, values in signals.items():
        for k in range(n):
            listed.append(values * one[k])
            names.append(f"{name}[{k + 1}]")
    return np.stack(listed, axis=2), names


def _bodies(model: mujoco.MjModel, state: State, at: Array) -> tuple[list[Array], list[str]]:
    """Differences of the torque by each body's mass, centre and inertia, and by each stiffness."""
    derivatives, names = list[Array](), list[str]()
    rigid = inverse(model, *state)

    def difference(name: str) -> None:
        derivatives.append((inverse(model, *state) - rigid)[:, at] / NUDGE)
        names.append(name)

    for joint in np.flatnonzero(model.jnt_stiffness):
        stiffness = float(model.jnt_stiffness[joint])
        model.jnt_stiffness[joint] = stiffness * (1 + NUDGE)
        difference(f"stiffness[{joint}]")
        model.jnt_stiffness[joint] = stiffness
    for body in range(1, model.nbody):
        size = np.sqrt(model.body_inertia[body].max() / model.body_mass[body])
        rows: list[tuple[str, Array, float]] = [
            ("m", model.body_mass[body : body + 1], float(model.body_mass[body]))
        ]
        rows += [(f"c{k}", model.body_ipos[body, k : k + 1], float(size)) for k in range(3)]
        rows += [
            (f"I{k}", model.body_inertia[body, k : k + 1], float(model.body_inertia[body].max()))
            for k in range(3)
        ]
        for name, entry, unit in rows:
            before = entry.copy()
            entry += NUDGE * unit
            difference(f"body[{body}].{name}")
            entry[:] = before
        for k in range(3):
            before = model.body_iquat[body].copy()
            turn = np.zeros(3)
            turn[k] = NUDGE
            mujoco.mju_quatIntegrate(model.body_iquat[body], turn, 1.0)
            difference(f"body[{body}].R{k}")
            model.body_iquat[body] = before
    return derivatives, names


def observable(
    case: Case,
    contributions: Sequence[Array],
    records: Sequence[Record],
    friction: bool = False,
    delays: Sequence[float] = (),
) -> Array:
    """RMS (n,) of the contribution that no base parameter can take up, one set for all records;
    both thinned. Weighted by each axis' torque RMS.

    delays: those of drives [s]. One that all drives have is the logger's, which is a base
    parameter, however long it is: that of `columns` is its tangent.
    """
    few = ROWS // (1 + 2 * (case.machine.chain is not None))
    thin = [slice(None, None, max(1, len(r.q) // few)) for r in records]
    scale = np.sqrt(np.mean(np.concatenate([r.u for r in records]) ** 2, axis=0))
    A = np.concatenate(
        [
            np.dstack([_thinned(case, r, s, friction), *_late(case, r, s, delays)]) / scale[:, None]
            for r, s in zip(records, thin, strict=True)
        ]
    )
    y = np.concatenate([g[s] / scale for g, s in zip(contributions, thin, strict=True)])
    flat = A.reshape(-1, A.shape[2])
    flat = flat / np.maximum(np.linalg.norm(flat, axis=0), 1e-300)
    solved = np.linalg.lstsq(flat, y.ravel(), rcond=1e-8)[0]
    left = (y.ravel() - flat @ solved).reshape(y.shape)
    return np.asarray(np.sqrt(np.mean(left**2, axis=0)) * scale)


def changed(case: Case, gaps: Sequence[Array], records: Sequence[Record], own: str) -> float:
    """RMS of what a changed parameter does to the torques, relative to theirs, that no other base
    parameter can take up within two standard deviations of its tolerance; own: a regular expression
    of the columns that may be reported for it."""
    few = ROWS // (1 + 2 * (case.machine.chain is not None))
    scale = np.sqrt(np.mean(np.concatenate([r.u for r in records]) ** 2, axis=0))
    rows, right, names = list[Array](), list[Array](), list[str]()
    for r, whole in zip(records, gaps, strict=True):
        s = slice(None, None, max(1, len(r.q) // few))
        _, names = columns(case, replace(r, q=r.q[:2], v=r.v[:2], a=r.a[:2], u=r.u[:2]), False)
        rows.append(_thinned(case, r, s, False) / scale[:, None])
        right.append(whole[s] / scale)
    A, y = np.concatenate(rows).reshape(-1, len(names)), np.concatenate(right).ravel()
    armature = np.array([link.armature for link in case.machine.links])
    within = np.full(len(names), np.inf)
    for k, name in enumerate(names):
        if name.startswith("body"):
            within[k] = 2 * case.mass_error
        elif name.startswith("rotor"):
            within[k] = 2 * case.mass_error * armature[int(name[6:-1]) - 1]
    others = [k for k, name in enumerate(names) if not re.match(own, name) and within[k] > 0]
    R = np.asarray(np.linalg.qr(np.column_stack([A[:, others], y]), mode="r"))
    limits = within[others]
    fit = lsq_linear(R[:, :-1], R[:, -1], (-limits, limits))
    # sums over the axes, as of an effect
    return float(np.sqrt(2 * fit.cost / y.size))


def _thinned(case: Case, r: Record, s: slice, friction: bool) -> Array:
    """Columns at some instants; the delay's is differentiated before it is thinned."""
    few = replace(r, q=r.q[s], v=r.v[s], a=r.a[s], u=r.u[s])
    listed, names = columns(case, few, friction)
    listed[:, :, names.index("delay")] = np.gradient(r.u, 1 / case.rate, axis=0)[s]
    return listed


def _late(case: Case, r: Record, s: slice, delays: Sequence[float]) -> list[Array]:
    """What delays [s] of all drives would do to the torques (samples, n), however long."""
    clock, listed = np.arange(len(r.u)) / case.rate, list[Array]()
    for seconds in delays:
        before = [np.interp(clock - seconds, clock, u) for u in r.u.T]
        listed.append((r.u - np.stack(before, axis=1))[s])
    return listed

"""MuJoCo's model of a machine, and its inverse dynamics."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from studies.mujoco import hexapod
from studies.mujoco.effect import Effect
from studies.mujoco.machine import Array, Machine, Parts, mjcf

CRANKS = 6


def compiled(machine: Machine, step: float, effects: Sequence[Effect]) -> mujoco.MjModel:
    """MuJoCo's model with what the effects change in it."""
    parts = Parts()
    for effect in effects:
        effect.change(parts, machine)
    if machine.chain is None:
        return mujoco.MjModel.from_xml_string(mjcf(machine, step, parts))
    text = hexapod.mjcf(machine.chain, machine.gravity, step, parts)
    return mujoco.MjModel.from_xml_string(text)


def places(model: mujoco.MjModel, n: int) -> Array:
    """Where the n axes stand among the model's degrees of freedom."""
    return np.array([model.joint(f"j{k + 1}").dofadr[0] for k in range(n)])


def inverse(model: mujoco.MjModel, q: Array, v: Array, a: Array, V: Array | None = None) -> Array:
    """Torques (samples, n_v) of MuJoCo's inverse dynamics.

    Of a closed chain those of the cut tree, projected on its cranks by V (samples, n_v, 6), see
    `hexapod.projections`; zero at the other joints.
    """
    if model.neq and V is None:
        V = hexapod.projections(model, q, places(model, CRANKS))
    usual = model.opt.disableflags
    model.opt.disableflags = usual | mujoco.mjtDisableBit.mjDSBL_EQUALITY.value
    try:
        out = _tree(model, q, v, a)
    finally:
        model.opt.disableflags = usual
    if V is not None:
        at = places(model, CRANKS)
        out[:, at], tree = np.einsum("sij,si->sj", V, out), out.copy()
        out[:, np.setdiff1d(np.arange(tree.shape[1]), at)] = 0.0
    return out


def _tree(model: mujoco.MjModel, q: Array, v: Array, a: Array) -> Array:
    data, out = mujoco.MjData(model), np.empty((len(q), model.nv))
    qpos, qvel, qacc, torques = data.qpos, data.qvel, data.qacc, data.qfrc_inverse
    for k in range(len(q)):
        qpos[:], qvel[:], qacc[:] = q[k], v[k], a[k]
        mujoco.mj_inverse(model, data)
        out[k] = torques
    return out

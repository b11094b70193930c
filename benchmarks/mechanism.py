"""N, and the chain N_F + N_E + F."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.blocks import block, harness
from benchmarks.clock import Rival, Row, Timing, measure
from benchmarks.dense import dense
from benchmarks.motion import feedforward_rows, kinematics, motion, poses
from flexhex.fmus.common.machine.machine import Machine


def step_N(machine: Machine, rounds: int) -> Row:
    """One tick of N against the paper's dense form, and Pinocchio where it is installed."""
    rows = np.hstack(motion(machine.timing.feedforward))
    ours, theirs = kinematics(machine), dense(machine, rows)
    rivals = [
        Rival("N: predict, correct, rates, accelerations", ours.ticks),
        Rival("dense 31x31 (C, -O3, pivoting LU)", theirs.ticks),
    ]
    notes = []
    try:
        from benchmarks.pinocchio_loops import constraint_dynamics

        rivals.append(constraint_dynamics())
    except ImportError:
        notes.append("Pinocchio is not installed (pip install pin)")
    return Row(
        "N", "N step with rates and accelerations", measure(rivals, rounds), 2e3, 1e3, notes=notes
    )


def chain(machine: Machine) -> Callable[[int], float]:
    """N_F, N_E and F after one another, F fed by N_F."""
    N_F, N_E = kinematics(machine), kinematics(machine)
    N_E.ticks(500)
    seen = poses(machine, 1)
    F = block("feedforward", machine, feedforward_rows(machine, seen))
    parts = (N_F, N_E, F)

    def run(count: int) -> float:
        # `parts` keeps alive what the C structs point to
        head = (*(ctypes.byref(part.c) for part in parts), ctypes.c_void_p(F.rows.ctypes.data))
        spent = harness().bench_chain(*head, ctypes.c_long(seen.shape[1]), ctypes.c_long(count))
        return float(spent)

    return run


def chain_row(machine: Machine, rounds: int) -> Row:
    """N_F + N_E + F against MuJoCo's inverse dynamics of the opened mechanism."""
    seen = poses(machine, 100)
    F = block("feedforward", machine, feedforward_rows(machine, seen))
    rivals = [Rival("N_F + N_E + F", chain(machine)), Rival("F alone", F.ticks)]
    notes = []
    try:
        rivals += mujoco_rivals()
    except ImportError:
        notes.append("MuJoCo is not installed (pip install mujoco)")
    timings = [*measure(rivals, rounds), Timing("paper", 490e3, 490e3, "its own computer")]
    return Row("chain", "N_F + N_E + F", timings, 8e3, 4e3, notes=notes)


def mujoco_rivals() -> list[Rival]:
    """mj_inverse in a C loop: the open tree, its closure given; and with our projection."""
    import mujoco

    from tests.oracles.machine import read_machine
    from tests.oracles.mujoco_tree import MujocoTree

    tree = MujocoTree(read_machine())
    rows = [part[100] for part in motion(0.0005)]
    state = tree.state(*rows)
    tree.data.qpos[:], tree.data.qvel[:], tree.data.qacc[:] = state
    call = _function(mujoco, "mj_inverse")

    def run(count: int) -> float:
        # asked for anew: what MuJoCo points to lives as long as `tree`
        model, data = (ctypes.c_void_p(part._address) for part in (tree.model, tree.data))
        return float(harness().bench_two_pointers(call, model, data, ctypes.c_long(count)))

    note = "loops already closed, no flexures, actuators, nor projection"
    return [Rival("MuJoCo mj_inverse (C)", run, note)]


def _function(mujoco: Any, name: str) -> Any:
    """Address of a function of MuJoCo's own library."""
    from pathlib import Path

    folder = Path(mujoco.__file__).parent
    libraries = sorted([*folder.glob("libmujoco*.so*"), *folder.glob("libmujoco*.dylib")])
    if not libraries:
        raise ImportError("MuJoCo's library is not where it is expected")
    return ctypes.cast(getattr(ctypes.CDLL(str(libraries[0])), name), ctypes.c_void_p)

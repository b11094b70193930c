"""The page's kinematics against a closure derived anew in NumPy."""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.conftest import ROOT
from tests.oracles.geometry import close, quaternion, rotation, split, upper_rotation
from tests.oracles.machine import Machine, read_machine

SCRIPT = ROOT / "flexhex" / "view" / "page" / "kinematics.js"
RUN = """
const fs = require("fs"), given = JSON.parse(fs.readFileSync(0, "utf8"));
const body = fs.readFileSync(process.argv[1], "utf8") + `
  const neutral = neutralFrames(given.machine), near = { x: given.machine.x_E0, lam: [1, 0, 0, 0] };
  return given.angles.map(theta => bodies(given.machine, neutral, theta, near));`;
console.log(JSON.stringify(new Function("given", body)(given)));
"""


def in_node(machine: Machine, angles: np.ndarray) -> Any:
    """What the page computes for angles (n, 6)."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node on the PATH")
    arms = [
        {key: getattr(machine, key)[i].tolist() for key in ("x_B", "axis", "u_B", "r_EP")}
        for i in range(6)
    ]
    sent = {"L": machine.L, "l": machine.l, "x_E0": machine.x_E0.tolist(), "arms": arms}
    done = subprocess.run(
        [node, "-e", RUN, str(SCRIPT)],
        input=json.dumps({"machine": sent, "angles": angles.tolist()}),
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return json.loads(done.stdout)


def lopsided(machine: Machine) -> Machine:
    """Joints of the platform moved by up to 20 mm on spheres about their lower arms' other ends."""
    rng = np.random.default_rng(4)
    Q = machine.x_B + machine.L * machine.u_B
    rod = machine.x_E0 + machine.r_EP + rng.uniform(-0.02, 0.02, (6, 3)) - Q
    rod *= machine.l / np.linalg.norm(rod, axis=1, keepdims=True)
    return replace(machine, r_EP=Q + rod - machine.x_E0)


def angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Between quaternions (..., 4) of either sign [rad]."""
    a = a / np.linalg.norm(a, axis=-1, keepdims=True)
    b = b / np.linalg.norm(b, axis=-1, keepdims=True)
    sign = np.sign(np.sum(a * b, axis=-1, keepdims=True))
    return np.asarray(2 * np.linalg.norm(a - sign * b, axis=-1))


@pytest.mark.parametrize("even", [True, False])
def test_bodies_of_the_page_are_those_of_the_closed_mechanism(even: bool) -> None:
    machine = read_machine() if even else lopsided(read_machine())
    angles = np.random.default_rng(7).uniform(-0.35, 0.35, (40, 6))
    angles[0] = 0.0
    theta, lam_Q, x_E, lam_E = split(close(machine, angles))
    result = in_node(machine, angles)
    assert all(pose["converged"] for pose in result)
    arms = [pose["arms"] for pose in result]
    got = {
        key: np.array([[arm[key] for arm in row] for row in arms])
        for key in ("Q", "P", "lam_Q", "lam_B", "rod", "rodE")
    }
    R_B = upper_rotation(machine, theta)
    Q = machine.x_B + machine.L * R_B[..., 0]
    P = Q + machine.l * rotation(lam_Q)[..., 0]
    # both sides close by Newton to rounding; 1e-11 leaves room for the condition of the mechanism
    assert np.abs(np.array([pose["x"] for pose in result]) - x_E).max() < 1e-11
    assert angle(np.array([pose["lam"] for pose in result]), lam_E).max() < 1e-11
    assert np.abs(got["Q"] - Q).max() < 1e-11
    assert np.abs(got["P"] - P).max() < 1e-11
    assert angle(got["lam_Q"], lam_Q).max() < 1e-11
    assert angle(got["lam_B"], quaternion(R_B)).max() < 1e-11
    assert np.abs(got["rod"] - (P - Q) / machine.l).max() < 1e-11
    rest = machine.R_Q0[..., 0]
    carried = np.einsum("nij,kj->nki", rotation(lam_E), rest)
    assert np.abs(got["rodE"] - carried).max() < 1e-11


def test_angles_that_the_mechanism_cannot_take_are_reported() -> None:
    """Neighbours apart by 2.8 rad: where the legs still close, flexures bend by a right angle.
    All angles a whole turn on: it closes as before, but no arm gets there."""
    angles = np.array([[1.4, -1.4] * 3, [0.3 + 2 * np.pi] * 6, [0.3, -0.3] * 3])
    results = in_node(read_machine(), angles)
    assert [pose["fits"] for pose in results] == [False, False, True]
    assert results[1]["converged"]

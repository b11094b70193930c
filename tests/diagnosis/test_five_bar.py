"""A closed chain through identify, diagnose and an FMU: the example's five-bar. Its torques are
derived anew here, by Lagrange from its energies."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from numpy.typing import NDArray

from examples.five_bar.five_bar import ARM, FOOT, GRAVITY, ROD, FiveBar
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.prepare import Options
from flexhex.diagnosis.workflow import diagnose
from flexhex.identify.inverse import write_fmu
from tests.compare import assert_close
from tests.conftest import ROOT
from tests.diagnosis.estimation import machines
from tests.diagnosis.estimation.test_inverse import played

Array = NDArray[np.float64]
BASE = f"{ROOT / 'examples/five_bar/five_bar.py'}:FiveBar"
T = np.arange(5000) * machines.TS
TIP = 0.3
"""Mass at the end of the second rod [kg], which the example does not have."""


@cache
def lagrange() -> ca.Function:
    """tau (2,) of q, v, a and ten parameters, from kinetic and potential energy."""
    q, v, a, p = ca.SX.sym("q", 2), ca.SX.sym("v", 2), ca.SX.sym("a", 2), ca.SX.sym("p", 10)
    elbow = [
        ca.vertcat(s * FOOT + ARM * ca.cos(q[i]), ARM * ca.sin(q[i])) for i, s in ((0, -1), (1, 1))
    ]
    across = elbow[1] - elbow[0]
    half = ca.norm_2(across) / 2
    up = ca.vertcat(-across[1], across[0]) / (2 * half)
    tip = (elbow[0] + elbow[1]) / 2 + ca.sqrt(ROD**2 - half**2) * up
    T, V = ca.SX(0), ca.SX(0)
    for i in range(2):
        mc, J = p[2 * i], p[2 * i + 1]
        T += J * v[i] ** 2 / 2
        V += mc * GRAVITY * ca.sin(q[i])
        m, mc, J = (p[4 + 3 * i + k] for k in range(3))
        way = (tip - elbow[i]) / ROD
        rate, turn = ca.jacobian(elbow[i], q) @ v, ca.jacobian(way, q) @ v
        T += (m * ca.dot(rate, rate) + 2 * mc * ca.dot(rate, turn) + J * ca.dot(turn, turn)) / 2
        V += GRAVITY * (m * elbow[i][1] + mc * way[1])
    push = ca.gradient(T, v)
    tau = (
        ca.jacobian(push, v) @ a + ca.jacobian(push, q) @ v - ca.gradient(T, q) + ca.gradient(V, q)
    )
    return ca.Function("tau", [q, v, a, p], [tau])


def motion(seed: int) -> tuple[Array, Array, Array]:
    """Arms that lean out, each by less than half a radian."""
    q, v, a = machines.moved(T, seed, (0.35, 0.35))
    return q + np.array([2.2, 0.9]), v, a


def truth() -> Array:
    """Parameters of the machine: a weight at the tip, arms 8 % lighter."""
    p = np.array([value for _, _, value, _ in FiveBar.parameters])
    p[:4] *= 0.92
    p[7:] += TIP * np.array([1, ROD, ROD**2])
    return p


def torques(seed: int, friction: float = 0.0) -> Array:
    q, v, a = motion(seed)
    computed = lagrange().map(len(T)).call([q.T, v.T, a.T, ca.repmat(ca.DM(truth()), 1, len(T))])
    tau: Array = computed[0].full().T
    return tau + machines.rubbed(v, (friction, 0.0), (0.0, 0.0))


def write_log(path: Path, seed: int, friction: float, head: str = "", noise: int = 0) -> Path:
    """A log of the motion of this seed, with friction of the first motor [N m]; noise: its seed."""
    q, _, _ = motion(seed)
    return machines.write(path, T, q, torques(seed, friction), (False,) * 2, head, noise)


def logs(folder: Path, seeds: tuple[int, ...], friction: float, passes: int = 1) -> list[Path]:
    listed = []
    for seed in seeds:
        for k in range(passes):
            head = f"# trajectory: {seed}\n# pass: {k + 1}\n"
            path = folder / f"{seed}-{k}.csv"
            listed.append(write_log(path, seed, friction, head, 10 * seed + k))
    return listed


def test_columns_are_those_of_lagrange() -> None:
    q, v, a = (part[:50] for part in motion(1))
    p = np.abs(np.random.default_rng(1).standard_normal(10))
    wanted = [lagrange().call([*row, p])[0].full().ravel() for row in zip(q, v, a, strict=True)]
    assert_close(FiveBar().columns(q, v, a) @ p, np.array(wanted), rtol=1e-10, what="torque")


def test_identify_predicts_and_its_fmu_does(tmp_path: Path) -> None:
    paths = logs(tmp_path, (1, 2, 3), 0.5)
    identified = identify(paths[:2], paths[2:], options=Options(BASE))
    assert identified.held_out is not None
    assert (identified.held_out.fitted < 0.01).all()
    assert (identified.held_out.file > 0.1).all()
    assert_close(identified["F_c[1]"].estimate.value, 0.5, rtol=1e-3)
    file = write_fmu(tmp_path / "five_bar.fmu", identified)
    got, wanted = played(file, *motion(3)), torques(3, 0.5)[1:-1]
    assert ((got - wanted).std(axis=0) < 0.01 * wanted.std(axis=0)).all()


def test_what_no_motion_tells_are_sums(tmp_path: Path) -> None:
    """A rod's mass acts as one at the end of its arm; its first moment is shared with the other
    rod, which carries it too: they meet."""
    identified = identify(logs(tmp_path, (1, 2), 0.0), options=Options(BASE))
    assert len(identified.combinations) < len(FiveBar.parameters)
    sums = {name for one in identified.combinations for name, _ in one.terms if len(one.terms) > 1}
    assert {"rod_1.m", "rod_2.m"} <= sums


@pytest.mark.slow
def test_hidden_friction_is_named(tmp_path: Path) -> None:
    diagnosis = diagnose(logs(tmp_path, (1, 2), 0.5, 2), options=Options(BASE))
    assert [(effect.id, effect.axes) for effect in diagnosis.effects] == [
        ("coulomb_friction", (1,))
    ]

"""E and K: equal to a textbook Kalman filter, healthy for hours, still where the mask says so."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np
import pytest

from flexhex.fmus.common.model.model import Model
from flexhex.fmus.common.model.parameters import base_parameters, parameters
from flexhex.fmus.estimator.interface import MOST_VARIANCE, first_variance, normalisation
from tests.blocks.loaded import Array, Loaded, StartError, build, load, machine
from tests.blocks.motions import random_instants
from tests.compare import assert_close
from tests.oracles.kalman import Kalman

N_P = 162


@cache
def samples(count: int) -> list[tuple[dict[str, Array], Array]]:
    """Inputs of the estimator but tau_f, and Phi (6, 162) there."""
    model = Model(machine())
    x, xd, xdd = (ca.SX.sym(name, 37) for name in ("x", "xd", "xdd"))
    theta, z, chi = ca.SX.sym("theta", 6), ca.SX.sym("z", 6), ca.SX.sym("chi", 114)
    basis = ca.Function("basis", [theta, z], [model.basis(theta, z)])
    Phi = ca.Function("Phi", [x, xd, xdd, chi], [ca.densify(model.regressor(x, xd, xdd, chi))])
    rows = []
    for at in random_instants(count, seed=11):
        chi_f = np.array(basis(at.x[:6], at.z)).ravel()
        inputs = {"x": at.x, "xd": at.xd, "xdd": at.xdd, "chi_f": chi_f}
        rows.append((inputs, np.array(Phi(at.x, at.xd, at.xdd, chi_f))))
    return rows


def started(t_start: float = 0.0, **parameters: object) -> Loaded:
    block = load("estimator")
    block.start(t_start=t_start, **parameters)
    return block


def textbook(block: Loaded) -> Kalman:
    """The oracle with the block's parameters."""
    p = block.p
    return Kalman(p["p0"], p["scale"], p["P0"], p["R1"], p["R2"], p["adapt"])


def covariance(block: Loaded) -> Array:
    """P (162, 162), normalised: behind q in the state, in blocks of 8.

    Blocks left of the diagonal and on it are kept, these whole: symmetric to the last bit.
    """
    rows = -(-N_P // 8) * 8
    kept = block.state[N_P : N_P + rows**2].reshape(rows, rows)
    for k in range(0, rows, 8):
        square = kept[k : k + 8, k : k + 8]
        assert np.array_equal(square, square.T)
        assert not kept[k : k + 8, k + 8 :].any()
    assert not kept[N_P:].any()
    P: Array = np.tril(kept[:N_P, :N_P])
    return P + np.tril(P, -1).T


def true_parameters(seed: int) -> Array:
    """A machine that differs from the nominal one by some percent and a payload of 0.4 kg."""
    p = base_parameters(machine())
    rng = np.random.default_rng(seed)
    p = p * (1 + 0.05 * rng.standard_normal(N_P))
    p[[par.name for par in parameters(machine())].index("end_effector.m")] += 0.4
    return p


def feed(block: Loaded, index: int, p: Array, noise: Array) -> tuple[Array, Array]:
    """One update with the torques of p; Phi and tau_f."""
    known = samples(500)
    inputs, Phi = known[index % len(known)]
    tau = Phi @ p + noise
    block.tick(**inputs, tau_f=tau)
    return Phi, tau


@pytest.mark.parametrize("masked", [False, True])
def test_estimator_equals_the_joseph_form(masked: bool) -> None:
    adapt = np.ones(N_P)
    if masked:
        adapt[::3] = 0.0
    block, rng, p = started(adapt=adapt), np.random.default_rng(1), true_parameters(1)
    twin = textbook(block)
    for k in range(1000):
        before = twin.q * twin.s
        Phi, tau = feed(block, k, p, rng.normal(0, 0.01, 6))
        expected, P = twin.step(Phi, tau)
        if k % 50 and k != 999:
            continue
        y, what = block.y, f"update {k}"
        # 1e-10 of each parameter's scale and of P0 = 1e-4: both run on rounding of 1e-16
        assert_close(y["p"] / twin.s, expected / twin.s, atol=1e-10, what=f"p, {what}")
        assert_close(covariance(block), P, atol=1e-14, what=f"P, {what}")
        std = twin.s * np.sqrt(np.diag(P))
        assert_close(y["p_std"] / twin.s, std / twin.s, atol=1e-10, what=f"p_std, {what}")
        assert_close(y["innovation"], tau - Phi @ before, atol=1e-11, what=f"innovation, {what}")


def test_estimator_leaves_masked_parameters_alone() -> None:
    adapt = np.ones(N_P)
    adapt[5::4] = 0.0
    block, p = started(adapt=adapt), true_parameters(2)
    for k in range(200):
        feed(block, k, p, np.zeros(6))
    still = adapt == 0.0
    assert np.array_equal(block.y["p"][still], block.p["p0"][still])
    assert not block.y["p_std"][still].any()
    assert not covariance(block)[still].any()
    assert (block.y["p"][~still] != block.p["p0"][~still]).all()


def test_estimator_with_nothing_to_adapt_publishes_p0() -> None:
    """The cases with fixed feedforward: exactly p0, also where p0 / scale * scale is not."""
    p0 = true_parameters(3)
    block = started(adapt=np.zeros(N_P), p0=p0)
    for k in range(20):
        feed(block, k, true_parameters(4), np.zeros(6))
        assert np.array_equal(block.y["p"], p0)


def healthy(block: Loaded) -> None:
    P = covariance(block)
    assert np.linalg.eigvalsh(P)[0] > 0
    assert np.isfinite(block.y.values).all()
    assert block.y["fault"] == 0.0


@pytest.mark.parametrize(
    "hours", [0.15, pytest.param(3.0, marks=pytest.mark.slow)], ids=lambda h: f"{h} h"
)
@pytest.mark.parametrize("still", [False, True], ids=["moving", "at rest"])
def test_estimator_stays_healthy_for_hours(hours: float, still: bool) -> None:
    """P symmetric to the last bit and positive definite, sampled; at rest nothing excites it."""
    block, rng, p = started(), np.random.default_rng(5), true_parameters(5)
    updates = round(hours * 3600 / 0.03)
    every = updates // 10
    for k in range(updates):
        feed(block, 0 if still else k, p, rng.normal(0, 0.01, 6))
        if k % every == 0:
            healthy(block)
    healthy(block)


def test_estimator_stays_healthy_at_the_ends_of_its_ranges() -> None:
    """No drift, the least noise and the largest P0 that the interface allows: P must not sink
    below zero (it does at R2 = 1e-12, with p and p_std NaN soon after)."""
    listed = {v.name: v for v in build("estimator", machine())[1].parameters}
    block = started(R1=np.zeros(N_P), R2=listed["R2"].min, P0=listed["P0"].max)
    p = true_parameters(10)
    for k in range(1000):
        feed(block, k, p, np.zeros(6))
        if k % 100 == 0:
            healthy(block)


def test_estimator_finds_the_torque_of_another_machine() -> None:
    """After 15 s of motion the torque is known to a few mN m, and the payload is seen."""
    block, rng, p = started(), np.random.default_rng(6), true_parameters(6)
    first = [np.abs(block.p["p0"] @ Phi.T - p @ Phi.T).max() for _, Phi in samples(500)]
    for k in range(500):
        feed(block, k, p, rng.normal(0, 0.01, 6))
    last = [np.abs(block.y["p"] @ Phi.T - p @ Phi.T).max() for _, Phi in samples(500)]
    assert np.sqrt(np.mean(np.square(last))) < 0.03 * np.sqrt(np.mean(np.square(first)))
    m = [par.name for par in parameters(machine())].index("end_effector.m")
    assert abs(block.y["p"][m] - p[m]) < 4 * block.y["p_std"][m] < 0.2


def test_estimator_waits_until_t_start() -> None:
    block, p = started(t_start=0.3), true_parameters(7)
    first = block.y["p"]
    for k in range(9):
        feed(block, k, p, np.zeros(6))
        assert np.array_equal(block.y["p"], first)
    feed(block, 9, p, np.zeros(6))
    assert (block.y["p"] != first).any()


def test_estimator_skips_what_is_no_pose() -> None:
    block, p = started(), true_parameters(8)
    feed(block, 0, p, np.zeros(6))
    estimate, P = block.y["p"], covariance(block).copy()
    block.tick(x=np.zeros(37))
    assert block.y["fault"] == 2.0
    assert np.array_equal(block.y["p"], estimate)
    assert np.array_equal(covariance(block), P)
    feed(block, 1, p, np.zeros(6))
    assert block.y["fault"] == 0.0


def test_estimator_first_outputs_follow_its_parameters() -> None:
    p0 = true_parameters(9)
    block = started(p0=p0, P0=4e-4)
    # p = scale (p0 / scale): within the last bit
    assert_close(block.y["p"] / p0, np.ones(N_P), atol=3e-16, what="p / p0")
    assert_close(block.y["p_std"], 0.02 * block.p["scale"], rtol=1e-15, what="p_std")


def test_estimator_first_variance_is_each_parameters_own() -> None:
    P0 = np.geomspace(1e-4, 1e-2, N_P)
    block = started(P0=P0)
    assert_close(block.y["p_std"], np.sqrt(P0) * block.p["scale"], rtol=1e-15, what="p_std")


def test_first_variance_is_the_fits_within_bounds() -> None:
    """0.1 % and 1 % count as the machine file's P0 = 1e-4, 5 % as it is, 30 % as 10 %."""
    p = true_parameters(7)
    scale, share = normalisation(machine(), p), np.resize([0.001, 0.01, 0.05, 0.3], N_P)
    expected = np.resize([1e-4, 1e-4, 2.5e-3, MOST_VARIANCE], N_P)
    assert_close(first_variance(machine(), p, share * scale), expected, rtol=1e-14, what="P0")
    assert first_variance(machine(), p, None).tolist() == [machine().control.P0] * N_P


def test_estimator_refuses_half_a_mask() -> None:
    adapt = np.ones(N_P)
    adapt[6] = 0.5
    with pytest.raises(StartError, match=r"^adapt\[7\] = 0.5, must be 0 or 1$"):
        started(adapt=adapt)

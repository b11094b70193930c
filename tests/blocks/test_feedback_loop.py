"""C in a closed loop around an inertia: settles, carries a load, comes back from its limits."""

from __future__ import annotations

import numpy as np

from tests.blocks.feedback_design import discrete_plant
from tests.blocks.loaded import Array, Loaded, machine
from tests.blocks.test_feedback import PLAIN, started


class Inertia:
    """1 / (J s^2) behind a current loop, sampled exactly, with a load torque."""

    def __init__(self, load_torque: float = 0.0) -> None:
        plant = discrete_plant(machine(), machine().control.J_design)
        self.A, self.B, self.C = plant.A, plant.B[:, 0], plant.C[0]
        self.x = np.zeros(len(self.A))
        self.load_torque = load_torque

    @property
    def theta(self) -> float:
        return float(self.C @ self.x)

    def step(self, tau: float) -> None:
        self.x = self.A @ self.x + self.B * (tau - self.load_torque)


def without_feedforward(**parameters: float) -> Loaded:
    """The feedback whose inputs are all zero; as an FMU it starts with the torque that holds."""
    block = started(**parameters, **PLAIN)
    block.u["tau_ff"] = 0.0
    return block


def loop(block: Loaded, plant: Inertia, r: Array) -> dict[str, Array]:
    """First joint in closed loop; the plant's own delay is the controller's step."""
    rows: dict[str, list[float]] = {"theta": [], "tau": [], "fault": []}
    for wanted in r:
        y = block.tick(r=np.full(6, wanted), theta=np.full(6, plant.theta))
        rows["theta"].append(plant.theta)
        rows["tau"].append(float(y["tau"][0]))
        rows["fault"].append(y["fault"])
        plant.step(rows["tau"][-1])
    return {name: np.array(values) for name, values in rows.items()}


def test_feedback_settles_after_a_step_and_carries_a_load() -> None:
    r = np.concatenate([np.zeros(4), np.full(8000, 0.02)])
    theta = loop(without_feedforward(), Inertia(load_torque=0.1), r)["theta"]
    # 45 deg with a PI corner at 1 Hz overshoots by half; the slowest pole is near that corner
    assert 0.025 < theta.max() < 0.031
    assert np.abs(theta[2000:] - 0.02).max() < 3e-3
    assert np.abs(theta[-400:] - 0.02).max() < 1e-6


def test_feedback_leaves_its_limit_as_soon_as_the_error_turns() -> None:
    """Three seconds in the limit would wind the integral up to 30 times the limit."""
    block = without_feedforward(tau_max=2.0)
    block.tick()
    for _ in range(12000):
        y = block.tick(theta=np.full(6, -0.1))
    assert y["fault"] == 2.0
    assert y["tau"].tolist() == [2.0] * 6
    saturated = block.tick(theta=np.full(6, -0.1))["tau_fb"]
    assert np.array_equal(saturated, y["tau_fb"]), "the integral went on"
    y = block.tick(theta=np.full(6, 0.001))
    assert y["tau"].tolist() == [-2.0] * 6
    for _ in range(200):
        y = block.tick(theta=np.full(6, 0.001))
    assert y["fault"] == 0.0
    assert np.abs(y["tau"]).max() < 0.3


def test_feedback_recovers_from_saturation_in_the_loop() -> None:
    r = np.concatenate([np.zeros(4), np.full(12000, 0.15)])
    row = loop(without_feedforward(tau_max=1.0), Inertia(), r)
    assert np.count_nonzero(row["fault"] == 2.0) > 400
    assert np.abs(row["tau"]).max() == 1.0
    assert row["theta"].max() < 0.27
    assert np.abs(row["theta"][-2000:] - 0.15).max() < 1e-4
    assert not row["fault"][-2000:].any()

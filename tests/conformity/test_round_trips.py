"""States of all FMUs, taken at random times of the adaptive loop, bring everything back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.conformity.loop import open_loop, restore

MOVING = {"reference": {"t_start": 0.05}}
"""The shipped experiment stands still for two seconds."""
AFTER = 100
"""Base steps that are compared behind each time."""


@pytest.mark.parametrize(
    ("moments", "end"),
    [(2, 1300), pytest.param(20, 6000, marks=pytest.mark.slow)],
)
def test_states_are_exact_at_random_times(
    hexapod_ssp: Path, tmp_path: Path, moments: int, end: int
) -> None:
    rng = np.random.default_rng(11)
    at = sorted(int(k) for k in rng.choice(np.arange(1, end), moments, replace=False))
    loop = open_loop(hexapod_ssp, tmp_path, MOVING)
    kept, trace = {}, []
    for n in range(end + AFTER):
        if n in at:
            kept[n] = (loop.states(), loop.now)
        loop.step()
        trace.append(loop.now)
    assert trace[-1]["K"] != trace[0]["K"], "the estimator has adapted"
    other = open_loop(hexapod_ssp, tmp_path, {})
    for n in reversed(at):
        states, now = kept[n]
        for name, data in states.items():
            restore(other.instances[name], data)
        assert other.states() == states, "bytes out are the bytes in"
        other.n, other.now = n, now
        for k in range(AFTER):
            other.step()
            assert other.now == trace[n + k], f"differs {k + 1} base steps after {n}"
    loop.free()
    other.free()

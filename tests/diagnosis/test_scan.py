"""States along samples: what goes with the shapes alone is computed once."""

from __future__ import annotations

import casadi as ca
import numpy as np

from flexhex.numeric.scan import _parted, scans
from tests.compare import assert_close


def leaky() -> ca.Function:
    """A state that decays by exp(-a) a sample and is fed by the mean of two inputs, times a."""
    state, before, now, fixed = (ca.SX.sym(name) for name in ("state", "before", "now", "fixed"))
    following = state * ca.exp(-fixed) + fixed * (before + now) / 2
    return ca.Function("scan_leaky", [state, before, now, fixed], [following])


def test_scan_is_the_recursion_written_out() -> None:
    inputs, a = np.sin(np.arange(50.0))[:, None], 0.3
    (scan,) = scans([leaky()])
    wanted = np.empty(50)
    wanted[0] = 2.0
    for k in range(1, 50):
        wanted[k] = wanted[k - 1] * np.exp(-a) + a * (inputs[k - 1, 0] + inputs[k, 0]) / 2
    states = scan(np.array([2.0]), inputs, np.array([a]))
    # rounding of fifty steps
    assert_close(states[:, 0], wanted, rtol=1e-13)


def test_step_has_no_function_of_the_shapes_alone() -> None:
    step, first = _parted(leaky())
    assert "exp" not in str(step.call(step.sx_in())[0])
    assert "exp" in str(first.call(first.sx_in())[0])

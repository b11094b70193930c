"""A tilt that the diagnosis finds is the tilt that the plant is built with."""

from __future__ import annotations

import casadi as ca
import numpy as np

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.basemodels.hexapod import HexapodBase
from flexhex.fmus.common.effects import library
from flexhex.fmus.common.machine_file import load_machine
from tests.conftest import MACHINE_FILE


def test_tilt_column_is_the_librarys_tilt() -> None:
    base = HexapodBase(load_machine(MACHINE_FILE))
    theta = 0.1 * np.sin(np.arange(30).reshape(5, 6))
    still = Motion(0.0, 0.001, theta, np.zeros_like(theta), np.zeros_like(theta))
    p = np.array([known.nominal for known in base.linear])
    columns = base.whole(still, p)["gravity_tilt"]
    g, small = np.array(base.machine.gravity.g), 1e-5
    for k, name in enumerate(("tilt_x", "tilt_y")):
        gains = {"tilt_x": 0.0, "tilt_y": 0.0, name: small}
        turned = library()["gravity_tilt"].mechanism(ca.SX(g.tolist()), gains)
        tilted = np.array(ca.DM(ca.evalf(turned))).ravel()
        wanted = (base._under(still, p, tilted) - base._under(still, p, g)) / small
        # second order of the tilt: 1e-5 of some N m
        np.testing.assert_allclose(columns[:, :, k], wanted, rtol=0, atol=2e-4)
        assert np.abs(wanted).max() > 1.0

"""Two links that swing in a vertical plane, a base model for `flexhex diagnose`:

flexhex diagnose RUN... --base FILE.py:TwoLinks
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LENGTH, GRAVITY = 0.4, 9.81  # of the first link [m]; [m/s2]


class TwoLinks:
    axes = ("rotary", "rotary")
    # name, unit, value, tolerance (one standard deviation); moments are those about the joint
    parameters = (
        ("link_1.mc", "kg m", 0.54, 0.03),
        ("link_1.J", "kg m2", 0.147, 0.007),
        ("link_2.m", "kg", 2.0, 0.1),
        ("link_2.mc", "kg m", 0.30, 0.015),
        ("link_2.J", "kg m2", 0.075, 0.004),
    )
    payload = ("link_2.m", "link_2.mc", "link_2.J")

    def columns(self, theta: Array, thetad: Array, thetadd: Array) -> Array:
        """Torques of both axes for one of each parameter, (samples, 2, 5)."""
        (q1, q2), (v1, v2), (a1, a2) = theta.T, thetad.T, thetadd.T
        near, across = LENGTH * np.cos(q2), LENGTH * np.sin(q2)
        weight_1, weight_2 = GRAVITY * np.cos(q1), GRAVITY * np.cos(q1 + q2)
        zero = np.zeros_like(q1)
        mc = near * (2 * a1 + a2) - across * (2 * v1 * v2 + v2**2) + weight_2
        first = weight_1, a1, LENGTH**2 * a1 + LENGTH * weight_1, mc, a1 + a2
        second = zero, zero, zero, near * a1 + across * v1**2 + weight_2, a1 + a2
        return np.stack([np.stack(first, axis=1), np.stack(second, axis=1)], axis=1)

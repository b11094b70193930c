"""A planar arm of two links behind gears that give way, in a closed loop: friction of its motors
makes the links swing. Simulated step by step, without the library's code."""

from __future__ import annotations

from math import cos, pi, sin, tanh

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
G, LENGTH = 9.81, 0.4
BODIES = ((8.0, 0.2, 0.15), (5.0, 0.18, 0.1))
"""Mass [kg], centre of mass along the link [m], inertia about it [kg m2]."""
ROTORS = (1.0, 0.3)
"""Behind the gears [kg m2]."""
DRY, VISCOUS, TURNS = (3.0, 1.5), (3.0, 1.2), 0.01
"""Friction of the motors [N m], [N m s/rad], and rate within which the dry one turns over
[rad/s]."""
STEP, EVERY, SECONDS, SETTLES = 1e-4, 10, 8.0, 1.5
"""Of the simulation [s], of the loop in steps, length of a run and time before it [s]."""
BANDWIDTH, DAMPING, STILL = 15.0, 1.4, 1e-3
"""Of the feedback [Hz], [1]; damping ratio of a gear."""
NOISE, DISTURBED, STEPS = 0.02, 0.3, 2e-6
"""Of the measured torques and of those that move the motors unseen [N m]; of the encoders [rad]."""
STARTS = (-0.9, 0.7)


def wanted(seed: int) -> Array:
    """Reference angle, rate and acceleration (3, 2, ticks) of a motion."""
    rng, ticks = np.random.default_rng(seed), round((SECONDS + SETTLES) / STEP / EVERY)
    t = STEP * EVERY * np.arange(ticks)
    turns = 2 * pi * np.ceil(rng.uniform(0.1, 0.8, 5) * SECONDS) / SECONDS
    size = rng.uniform(0.1, 0.25, (2, 5)) / (1 + turns / (2 * pi))
    x = turns * t[:, None, None] + rng.uniform(0, 2 * pi, (2, 5))
    waves = np.sin(x), turns * np.cos(x), -(turns**2) * np.sin(x)
    listed = np.stack([(size * wave).sum(axis=2).T for wave in waves])
    listed[0] += np.array(STARTS)[:, None]
    return listed


def run(seed: int, number: int, stiffness: tuple[float, float]) -> dict[str, Array]:
    """time, theta, tau_meas of a pass of the motion `seed`; stiffness [N m/rad] of the gears."""
    rng, reference = np.random.default_rng([seed, number]), wanted(seed)
    ticks = reference.shape[2]
    unseen = DISTURBED * rng.standard_normal((ticks, 2)) * (1.0, 0.4)
    motor, link = reference[0, :, 0].tolist(), reference[0, :, 0].tolist()
    motor_rate, link_rate = reference[1, :, 0].tolist(), reference[1, :, 0].tolist()
    (m1, c1, I1), (m2, c2, I2) = BODIES
    own, near = I2 + m2 * c2**2, m2 * LENGTH * c2
    rows = np.empty((ticks, 4))
    w = 2 * pi * BANDWIDTH
    for k in range(ticks):
        held = 2 * near * cos(motor[1])
        loads = I1 + m1 * c1**2 + own + m2 * LENGTH**2 + held, own
        weight = m2 * G * c2 * cos(motor[0] + motor[1])
        weights = (m1 * c1 + m2 * LENGTH) * G * cos(motor[0]) + weight, weight
        given = [0.0, 0.0]
        for i in (0, 1):
            theta, rate, acceleration = reference[:, i, k]
            read = round(motor[i] / STEPS) * STEPS
            asked = w**2 * (theta - read) + DAMPING * w * (rate - motor_rate[i]) + acceleration
            given[i] = (loads[i] + ROTORS[i]) * asked + weights[i]
            rows[k, i], rows[k, 2 + i] = read, given[i]
        for _ in range(EVERY):
            across = near * sin(link[1])
            M12 = own + near * cos(link[1])
            M11 = I1 + m1 * c1**2 + m2 * LENGTH**2 + M12 + near * cos(link[1])
            g2 = m2 * G * c2 * cos(link[0] + link[1])
            g1 = (m1 * c1 + m2 * LENGTH) * G * cos(link[0]) + g2
            passed = [0.0, 0.0]
            for i, mass in ((0, M11), (1, own)):
                k_i = stiffness[i]
                apart = motor[i] - link[i], motor_rate[i] - link_rate[i]
                passed[i] = k_i * apart[0] + 2 * STILL * (k_i * mass) ** 0.5 * apart[1]
                rubbed = DRY[i] * tanh(motor_rate[i] / TURNS) + VISCOUS[i] * motor_rate[i]
                more = given[i] + unseen[k, i] - rubbed - passed[i]
                motor_rate[i] += STEP * more / ROTORS[i]
            v1, v2 = link_rate
            b1 = passed[0] + across * (2 * v1 * v2 + v2**2) - g1
            b2 = passed[1] - across * v1**2 - g2
            whole = M11 * own - M12**2
            link_rate[0] += STEP * (own * b1 - M12 * b2) / whole
            link_rate[1] += STEP * (M11 * b2 - M12 * b1) / whole
            for i in (0, 1):
                motor[i] += STEP * motor_rate[i]
                link[i] += STEP * link_rate[i]
    rows = rows[round(SETTLES / STEP / EVERY) :]
    rows[:, 2:] += NOISE * rng.standard_normal((len(rows), 2))
    clock = STEP * EVERY * np.arange(len(rows))
    return {"time": clock, "theta": rows[:, :2], "tau_meas": rows[:, 2:]}

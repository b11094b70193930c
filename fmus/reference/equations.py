"""Reference motions of one pass: angles with their exact first and second derivatives.

Time t [s] runs from the begin of the thing described (a move, a pass). All motions but
the triangle are differentiated by CasADi, so r, rd and rdd belong together to rounding.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from flexhex.fmus.common.machine.machine import Machine

MAX_SINES = 16
"""Most sines of a multisine."""


def transition(u: ca.SX) -> ca.SX:
    """Share of a move that is done after the share u of its time, both 0..1.  [SH, V-A]

    Piecewise linear acceleration: it rises to 8 at u = 1/4, falls to -8 at 3/4, rises to
    0 at 1. The print names the shape alone; this is its shortest symmetric form, with
    continuous acceleration and rest at both ends.
    """
    early, late = 16 * u**3 / 3, 1 - 16 * (1 - u) ** 3 / 3
    w = u - 0.5
    middle = 0.5 + 2 * w - 16 * w**3 / 3
    return ca.if_else(u <= 0.25, early, ca.if_else(u >= 0.75, late, middle))


def smooth_step(u: Any) -> Any:
    """10 u^3 - 15 u^4 + 6 u^5 for u in 0..1, SX or arrays: 0 to 1, at rest at both ends.

    Rate and curvature vanish there.
    """
    return u**3 * (10 + u * (6 * u - 15))


def fading(t: ca.SX, T: ca.SX, fade: ca.SX) -> ca.SX:
    """Envelope 0..1 that rises within `fade` [s] and falls as long before T [s].

    Each flank is a `smooth_step`.
    """
    envelope: ca.SX = smooth_step(ca.fmin(ca.fmin(t, T - t) / fade, 1))
    return envelope


def multisine(t: ca.SX, f_base: ca.SX, n_sines: ca.SX, phase: ca.SX) -> ca.SX:
    """Mean of n_sines sines at 1, 2, ... times f_base [Hz]; phase (MAX_SINES,) [rad]."""
    k = np.arange(1, MAX_SINES + 1)
    waves = ca.sin(2 * ca.pi * f_base * t * ca.DM(k) + phase)
    return ca.dot(ca.DM(k) <= n_sines, waves) / n_sines


def chirp(t: ca.SX, T: ca.SX, f0: ca.SX, f1: ca.SX) -> ca.SX:
    """Sine whose frequency goes linearly from f0 to f1 [Hz] while t goes from 0 to T [s]."""
    return ca.sin(2 * ca.pi * t * (f0 + (f1 - f0) * t / (2 * T)))


def triangle_times(amplitude: ca.SX, speed: ca.SX, rounding: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Time of one cycle of the triangle, and what starting and stopping add to all cycles [s].

    A quarter takes amplitude / speed + speed / (2 rounding): the corners lose half of the
    time they take. To start from rest takes speed / (2 rounding) longer, and so does to stop.
    """
    return 4 * amplitude / speed + 2 * speed / rounding, speed / rounding


def triangle(
    t: ca.SX, cycles: ca.SX, amplitude: ca.SX, speed: ca.SX, rounding: ca.SX
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Angle, rate, acceleration of a slow triangle with rounded corners, at rest at both ends.

    Between the corners the rate is +-speed, in them the acceleration -+rounding; the peaks
    are +-amplitude. t is folded into one quarter: the motion is odd about its begin, about
    its end and about every zero between, even about every peak. Start and stop take the
    first and last part of a quarter with the acceleration `rounding`. Zero amplitude or no
    cycle: rest. Needs amplitude >= speed^2 / rounding.
    """
    cycle, extra = triangle_times(amplitude, speed, rounding)
    T = cycles * cycle + extra
    back = t > T / 2
    s = ca.fmax(ca.if_else(back, T - t, t), 0)  # r(T - t) = -r(t): only the first half is made
    starting = s < extra
    q = (s - extra / 2) / cycle
    w = (q - ca.floor(q + 0.25)) * cycle  # time since the last rising zero, -1/4..3/4 cycle
    falling = w > cycle / 4
    v = ca.if_else(falling, cycle / 2 - w, w)  # on the rising flank, -1/4..1/4 cycle
    to_peak = cycle / 4 - ca.fabs(v)
    corner = to_peak < extra
    r_corner = ca.sign(v) * (amplitude - rounding * to_peak**2 / 2)
    r = ca.if_else(corner, r_corner, speed * v)
    rd = ca.if_else(corner, rounding * to_peak, speed)
    rdd = ca.if_else(corner, -ca.sign(v) * rounding, 0)
    rd = ca.if_else(falling, -rd, rd)
    r = ca.if_else(starting, rounding * s**2 / 2, r)
    rd = ca.if_else(starting, rounding * s, rd)
    rdd = ca.if_else(starting, rounding, rdd)
    moves = (cycles > 0) * (t < T)
    odd = ca.if_else(back, -1, 1)
    return moves * odd * r, moves * rd, moves * odd * rdd


def derived(r: ca.SX, t: ca.SX) -> list[ca.SX]:
    """[r, rd, rdd], r (n,) differentiated by t."""
    rd = ca.jacobian(r, t)
    return [r, rd, ca.jacobian(rd, t)]


def functions(machine: Machine) -> list[ca.Function]:
    """Functions of step.c; r (6,) [rad], rd, rdd out of each but the second.

    reference_random(t, move, r_from, r_to): move [s] from setpoint to setpoint (6,) [rad]
    reference_cycles(T, amplitude, speed, rounding) -> cycles (6,): whole ones that fit into T
    reference_triangle(t, cycles, amplitude, speed, rounding)
    reference_multisine(t, T, fade, f_base, n_sines, phase, amplitude): phase (6 MAX_SINES,)
    reference_chirp(t, T, fade, f0, f1, amplitude)
    """
    n = machine.n_arms
    names = "t T move fade speed rounding f_base n_sines f0 f1"
    s = {name: ca.SX.sym(name) for name in names.split()}
    s |= {name: ca.SX.sym(name, n) for name in ("amplitude", "cycles", "r_from", "r_to")}
    s["phase"] = ca.SX.sym("phase", n * MAX_SINES)
    t, T, amplitude, speed, rounding = (s[k] for k in ["t", "T", "amplitude", "speed", "rounding"])
    window = fading(t, T, s["fade"])

    def function(name: str, arguments: str, values: list[ca.SX], results: str = "r rd rdd") -> Any:
        given = arguments.split()
        inputs = [s[k] for k in given]
        return ca.Function(f"reference_{name}", inputs, ca.cse(values), given, results.split())

    random = s["r_from"] + (s["r_to"] - s["r_from"]) * transition(t / s["move"])
    phases = ca.vertsplit(s["phase"], MAX_SINES)
    sines = ca.vertcat(*(multisine(t, s["f_base"], s["n_sines"], phase) for phase in phases))
    sweep = chirp(t, T, s["f0"], s["f1"])
    cycle, extra = triangle_times(amplitude, speed, rounding)
    fitting = (amplitude > 0) * ca.fmax(ca.floor((T - extra) / cycle), 0)
    joints = [triangle(t, s["cycles"][i], amplitude[i], speed, rounding) for i in range(n)]
    slow = [ca.vertcat(*parts) for parts in zip(*joints, strict=True)]
    return [
        function("random", "t move r_from r_to", derived(random, t)),
        function("cycles", "T amplitude speed rounding", [fitting], "cycles"),
        function("triangle", "t cycles amplitude speed rounding", slow),
        function(
            "multisine",
            "t T fade f_base n_sines phase amplitude",
            derived(amplitude * window * sines, t),
        ),
        function("chirp", "t T fade f0 f1 amplitude", derived(amplitude * window * sweep, t)),
    ]

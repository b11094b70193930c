"""A motion between two rows of a table: the quintic that has the values and rates of both."""

from __future__ import annotations

import casadi as ca

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.player.table import Kind, channels


def quintic(t: ca.SX, h: ca.SX, first: list[ca.SX], last: list[ca.SX]) -> ca.SX:
    """Value (n,) at the time t [s] after the first row; the rows are h [s] apart.

    first, last: value, rate, acceleration (n,) of each row. The polynomial of degree five is the
    only one with these six, so neighbours join with continuous rate and acceleration.
    """
    u = t / h
    y0, v0, a0 = first[0], h * first[1], h**2 * first[2]
    y1, v1, a1 = last[0], h * last[1], h**2 * last[2]
    dy, dv, da = y1 - y0 - v0 - a0 / 2, v1 - v0 - a0, a1 - a0
    c3 = 10 * dy - 4 * dv + da / 2
    c4 = -15 * dy + 7 * dv - da
    c5 = 6 * dy - 3 * dv + da / 2
    return y0 + u * (v0 + u * (a0 / 2 + u * (c3 + u * (c4 + u * c5))))


def functions(machine: Machine, kind: Kind) -> list[ca.Function]:
    """Functions of step.c.

    player_between(t, h, first, last) -> motion (3 n,): values, rates, accelerations, as in a row
    """
    n = channels(machine, kind)
    t, h = ca.SX.sym("t"), ca.SX.sym("h")
    first, last = ca.SX.sym("first", 3 * n), ca.SX.sym("last", 3 * n)
    value = quintic(t, h, ca.vertsplit(first, n), ca.vertsplit(last, n))
    rate = ca.jacobian(value, t)
    motion = ca.cse([ca.vertcat(value, rate, ca.jacobian(rate, t))])
    names = ["t", "h", "first", "last"]
    return [ca.Function("player_between", [t, h, first, last], motion, names, ["motion"])]

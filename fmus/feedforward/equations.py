"""Feedforward F: the inverse dynamics (24) at the wanted motion, (31)."""

from __future__ import annotations

import casadi as ca

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.effect_bank import SIGNALS, followers, instant
from flexhex.fmus.common.model.model import Model

STEPS = 4
"""Fixed-point steps for the losses of the drives."""


def functions(machine: Machine) -> list[ca.Function]:
    """feedforward_torque(x, xd, xdd, z, p) -> tau_ff (6,) [N m].  [SH, Eq. (31)]

    with effects, feedforward_torque leaves them out; beside it
    feedforward_with_effects(now, state, p) -> tau_ff, now.tau being that of feedforward_torque
    feedforward_effect_torque_rate(before, last, tau, Ts) -> taud: `torque_rate`
    and `followers` of effect_bank
    """
    model = Model(machine)
    x, xd, xdd = (ca.SX.sym(name, model.n_x) for name in ("x", "xd", "xdd"))
    z, p = ca.SX.sym("z", model.n), ca.SX.sym("p", model.n_p)
    tau = model.base_torque(x, xd, xdd, model.basis(x[: model.n], z), p)
    return [
        ca.Function(
            "feedforward_torque",
            [x, xd, xdd, z, p],
            ca.cse([tau]),
            ["x", "xd", "xdd", "z", "p"],
            ["tau_ff"],
        ),
        *effects(model),
    ]


def torque_rate(before: ca.SX, last: ca.SX, tau: ca.SX, Ts: ca.SX) -> ca.SX:
    """Rate at the newest of three samples, second order: (tau_-2 - 4 tau_-1 + 3 tau) / (2 Ts)."""
    return (3 * tau - 4 * last + before) / (2 * Ts)


def effects(model: Model) -> list[ca.Function]:
    """Functions of effects.h; none without effects.

    A drive's loss depends on the torque that it reports, which is the sum itself: STEPS
    fixed-point steps of tau <- base + gain column(tau). Each reduces the error to a few percent,
    the derivative of the loss by the torque.
    """
    bank, n = model.bank, model.n
    if not bank:
        return []
    now, state = ca.SX.sym("now", len(SIGNALS) * n + 1), ca.SX.sym("state", bank.n_states)
    p = ca.SX.sym("p", model.n_p)
    at = SIGNALS.index("tau") * n
    base = tau = now[at : at + n]
    for _ in range(STEPS):
        columns = bank.columns(instant(ca.vertcat(now[:at], tau, now[at + n :]), n), state)
        tau = base + bank.on_axes(p[model.n_base :], columns)
    whole = ca.Function(
        "feedforward_with_effects",
        [now, state, p],
        [ca.cse(tau)],
        ["now", "state", "p"],
        ["tau_ff"],
    )
    before, last, newest = (ca.SX.sym(name, n) for name in ("before", "last", "tau"))
    Ts = ca.SX.sym("Ts")
    rate = ca.Function(
        "feedforward_effect_torque_rate",
        [before, last, newest, Ts],
        [torque_rate(before, last, newest, Ts)],
        ["before", "last", "tau", "Ts"],
        ["taud"],
    )
    return [whole, *followers(bank, "feedforward"), rate]

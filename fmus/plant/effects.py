"""The plant's effects: torques and losses of the drives, states, lags, what the encoders read."""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca

from flexhex.fmus.common.effects import Effect
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.effect_bank import Bank, instant

SUBSTEPS = 64
"""Most integration steps a tick."""


@dataclass(frozen=True)
class Inputs:
    """What the effects add to the arguments of plant_rates, and its state.

    tau_motor (n,): torque that the drives report; taud (n,): its rate; time [s]; state
    (n_states,); effect (n_gains,): gains.
    """

    tau_motor: ca.SX
    taud: ca.SX
    time: ca.SX
    state: ca.SX
    effect: ca.SX

    @staticmethod
    def of(bank: Bank) -> Inputs:
        """Symbols for a bank."""
        return Inputs(
            ca.SX.sym("tau_motor", bank.n),
            ca.SX.sym("taud", bank.n),
            ca.SX.sym("time"),
            ca.SX.sym("state", bank.n_states),
            ca.SX.sym("effect", bank.n_gains),
        )

    @property
    def symbols(self) -> list[ca.SX]:
        """In the order of the arguments."""
        return [self.tau_motor, self.taud, self.time, self.state, self.effect]


INPUT_NAMES = ("tau_motor", "taud", "time", "state", "effect")


def torque(bank: Bank, theta: ca.SX, thetad: ca.SX, given: Inputs) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Torque (n,) that the effects take, its part in thetadd (n, n), rates of the states.

    What the joints get less is torque + part thetadd: columns may be linear in thetadd. Drive
    effects with a `line` of their own are left to it.
    """
    n, wanted = bank.n, [_in_equations(part.effect) for part, _ in bank.gains]
    thetadd = ca.SX.sym("thetadd", n)
    at = ca.vertcat(theta, thetad, thetadd, given.tau_motor, given.taud, given.time)
    signals = instant(at, n)
    taken = bank.on_axes(given.effect, bank.columns(signals, given.state), wanted)
    part = ca.sparsify(ca.jacobian(taken, thetadd))
    rest = ca.substitute(
        ca.vertcat(taken, bank.rate(signals, given.state)), thetadd, ca.SX.zeros(n)
    )
    return rest[:n], part, rest[n:]


def simpson_middle(start: ca.SX, mean: ca.SX, end: ca.SX) -> ca.SX:
    """Value in the middle for which Simpson's rule gives the mean exactly."""
    return (6 * mean - start - end) / 4


def lagged_torque(
    tau: ca.SX, command: ca.SX, f_current: ca.SX, T: ca.SX, h: ca.SX, x: ca.SX
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Torque [N m] behind a lag T x' = tau - x [s] at start, middle and end of a time h [s].

    tau, x: torques before and behind the lag at the start; tau follows `command` as in
    `equations.drive_torque`. In closed form; the middle value gives the exact impulse.
    """
    gap, rate, decay = tau - command, 2 * ca.pi * f_current, 1 / T
    apart = (decay - rate) * h
    shared = ca.if_else(apart != 0, -ca.expm1(-apart) / apart, 1)
    through = decay * h * ca.exp(-rate * h) * shared
    mean_tau = command - gap * ca.expm1(-rate * h) / (rate * h)
    end = command + gap * through + (x - command) * ca.exp(-decay * h)
    return x, simpson_middle(x, mean_tau - T * (end - x) / h, end), end


def _in_equations(effect: Effect) -> bool:
    return effect.acts_on in ("torque", "drive") and not effect.line


def functions(bank: Bank) -> list[ca.Function]:
    """Functions of effects.h, beside plant_rates; none without effects.

    plant_effect_start(theta) -> state (n_states,)
    plant_effect_lines(effect) -> lag, delay (n,) [s]
    plant_effect_reading(theta, tau, effect) -> reading (n,): what the encoders see, tau: torque of
    the motors
    plant_effect_lag(tau, command, f_current, T, h, x) -> start, middle, end: one axis
    """
    if not bank:
        return []
    n = bank.n
    theta, tau, effect = (
        ca.SX.sym(*a) for a in (("theta", n), ("tau", n), ("effect", bank.n_gains))
    )
    one = ca.SX.ones(bank.n_gains)
    lag, delay = (
        bank.on_axes(effect, one, [part.effect.line == line for part, _ in bank.gains])
        for line in ("lag", "delay")
    )
    still = ca.vertcat(theta, ca.SX.zeros(2 * n), tau, ca.SX.zeros(n + 1))
    columns = bank.columns(instant(still, n), ca.SX.zeros(bank.n_states))
    read = [part.effect.acts_on == "measurement" for part, _ in bank.gains]
    reading = theta + bank.on_axes(effect, columns, read)
    return [
        ca.Function("plant_effect_start", [theta], [bank.start(theta)], ["theta"], ["state"]),
        ca.Function("plant_effect_lines", [effect], [lag, delay], ["effect"], ["lag", "delay"]),
        ca.Function(
            "plant_effect_reading",
            [theta, tau, effect],
            [reading],
            ["theta", "tau", "effect"],
            ["reading"],
        ),
        _lag(),
    ]


def _lag() -> ca.Function:
    names = ["tau", "command", "f_current", "T", "h", "x"]
    symbols = [ca.SX.sym(name) for name in names]
    torques = ca.cse(list(lagged_torque(*symbols)))
    return ca.Function("plant_effect_lag", symbols, torques, names, ["start", "middle", "end"])


def constants(machine: Machine) -> dict[str, int]:
    """Sizes for effects.h: LINE is how many substeps a delay can reach back."""
    bank = Bank.all(machine)
    if not bank:
        return {}
    reach = [gain.high for part, gain in bank.gains if part.effect.line == "delay"]
    length = math.ceil(sum(reach) / machine.timing.base * SUBSTEPS) + 2
    return {**bank.constants, "LINE": length}

"""The plant's effects: torques and losses of the drives, states, lags, what the encoders read."""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca

from flexhex.fmus.common.effects import Effect
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.effect_bank import SIGNALS, Bank, instant

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


def _in_equations(effect: Effect) -> bool:
    return effect.acts_on in ("torque", "drive") and not effect.line


def functions(bank: Bank) -> list[ca.Function]:
    """Functions of effects.h, beside plant_rates; none without effects.

    plant_effect_start(theta) -> state (n_states,)
    plant_effect_lines(effect) -> lag, delay (n,) [s]
    plant_effect_reading(theta, effect) -> reading (n,): what the encoders see
    """
    if not bank:
        return []
    n = bank.n
    theta, effect = ca.SX.sym("theta", n), ca.SX.sym("effect", bank.n_gains)
    one = ca.SX.ones(bank.n_gains)
    lag, delay = (
        bank.on_axes(effect, one, [part.effect.line == line for part, _ in bank.gains])
        for line in ("lag", "delay")
    )
    still = ca.vertcat(theta, ca.SX.zeros((len(SIGNALS) - 1) * n + 1))
    columns = bank.columns(instant(still, n), ca.SX.zeros(bank.n_states))
    read = [part.effect.acts_on == "measurement" for part, _ in bank.gains]
    reading = theta + bank.on_axes(effect, columns, read)
    return [
        ca.Function("plant_effect_start", [theta], [bank.start(theta)], ["theta"], ["state"]),
        ca.Function("plant_effect_lines", [effect], [lag, delay], ["effect"], ["lag", "delay"]),
        ca.Function(
            "plant_effect_reading", [theta, effect], [reading], ["theta", "effect"], ["reading"]
        ),
    ]


def constants(machine: Machine) -> dict[str, int]:
    """Sizes for effects.h: LINE is how many substeps a delay can reach back."""
    bank = Bank.all(machine)
    if not bank:
        return {}
    reach = [gain.high for part, gain in bank.gains if part.effect.line == "delay"]
    length = math.ceil(sum(reach) / machine.timing.base * SUBSTEPS) + 2
    return {**bank.constants, "LINE": length}

"""The effects of one machine side by side: their gains, states and columns as vectors.

A bank lists, entry by entry and axis by axis, what an FMU needs: `known` what the estimator
adapts and the feedforward compensates, `real` all that the plant has.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca

from flexhex.fmus.common.effects import Effect, Gain, Signals
from flexhex.fmus.common.machine.machine import Machine

SIGNALS = ("theta", "thetad", "thetadd", "tau", "taud")


@dataclass(frozen=True)
class PlacedEffect:
    """One effect on one axis (from 0): label, values of its gains, its shapes."""

    effect: Effect
    axis: int
    label: str
    gains: tuple[float, ...]
    shape: dict[str, float]


@dataclass(frozen=True)
class Bank:
    """Parts for a machine of n axes; gains and states are vectors in their order."""

    n: int
    parts: tuple[PlacedEffect, ...]

    @staticmethod
    def all(machine: Machine) -> Bank:
        """All that acts in the plant, but what changes the mechanism."""
        return Bank.of(machine, lambda effect: effect.acts_on != "mechanism")

    @staticmethod
    def compensated(machine: Machine) -> Bank:
        """Torques that the feedforward compensates: their gains belong to p."""
        return Bank.of(machine, compensated)

    @staticmethod
    def of(machine: Machine, wanted: Callable[[Effect], bool]) -> Bank:
        """The parts whose effect is wanted, in the order of the machine file."""
        parts, seen = [], list[tuple[str, int]]()
        for use in machine.effects:
            times = max((seen.count((use.id, axis)) for axis in use.axes), default=0)
            label = use.id if not times else f"{use.id}_{times + 1}"
            seen += [(use.id, axis) for axis in use.axes]
            if not wanted(use.effect):
                continue
            for k, axis in enumerate(use.axes):
                gains = tuple(row[k] for row in use.gains)
                parts.append(PlacedEffect(use.effect, axis - 1, label, gains, use.shape))
        return Bank(machine.n_arms, tuple(parts))

    def __bool__(self) -> bool:
        return bool(self.parts)

    @property
    def gains(self) -> tuple[tuple[PlacedEffect, Gain], ...]:
        """Every gain with the part that it belongs to."""
        return tuple((part, gain) for part in self.parts for gain in part.effect.gains)

    @property
    def names(self) -> tuple[str, ...]:
        """`coulomb_friction.F_c[3]`, ..."""
        return tuple(f"{part.label}.{gain.name}[{part.axis + 1}]" for part, gain in self.gains)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of every gain."""
        return tuple(gain.unit for _, gain in self.gains)

    @property
    def values(self) -> tuple[float, ...]:
        """Every gain as the machine file has it."""
        return tuple(value for part in self.parts for value in part.gains)

    @property
    def n_gains(self) -> int:
        """Number of gains, which is the number of columns."""
        return len(self.gains)

    @property
    def n_states(self) -> int:
        """Number of states, at least one (that stays zero): C has no empty arrays."""
        return max(1, sum(len(part.effect.states) for part in self.parts))

    def _states(self, listed: list[ca.SX]) -> ca.SX:
        return ca.vertcat(*listed) if listed else ca.SX.zeros(1)

    @property
    def constants(self) -> dict[str, int]:
        """Sizes for the C of an FMU; nothing without effects."""
        if not self:
            return {}
        return {"N_EFFECT": self.n_gains, "N_EFFECT_STATE": self.n_states}

    def columns(self, signals: Sequence[Signals], state: ca.SX) -> ca.SX:
        """What one unit of each gain gives on its axis (n_gains,); signals: axis by axis."""
        listed = [
            part.effect.columns(signals[part.axis], mine, part.shape)
            for part, mine in self._with_states(state)
        ]
        return ca.vertcat(ca.SX(0, 1), *listed)

    def rate(self, signals: Sequence[Signals], state: ca.SX) -> ca.SX:
        """d state / dt (n_states,)."""
        listed = [
            part.effect.rate(signals[part.axis], mine, part.shape)
            for part, mine in self._with_states(state)
            if part.effect.states
        ]
        return self._states(listed)

    def advance(
        self, before: Sequence[Signals], now: Sequence[Signals], state: ca.SX, Ts: ca.SX
    ) -> ca.SX:
        """The state (n_states,) at `now`, Ts [s] after `before`."""
        listed = [
            part.effect.advance(before[part.axis], now[part.axis], mine, part.shape, Ts)
            for part, mine in self._with_states(state)
            if part.effect.states
        ]
        return self._states(listed)

    def start(self, theta: ca.SX) -> ca.SX:
        """The state (n_states,) at rest at theta (n,)."""
        listed = [
            part.effect.start(Signals.resting(theta[part.axis]), part.shape)
            for part in self.parts
            if part.effect.states
        ]
        return self._states(listed)

    def on_axes(self, gains: ca.SX, columns: ca.SX, wanted: Sequence[bool] = ()) -> ca.SX:
        """Sum of gain times column on every axis (n,); wanted: which of the gains count."""
        total = ca.SX.zeros(self.n)
        for k, (part, _) in enumerate(self.gains):
            if not wanted or wanted[k]:
                total[part.axis] += gains[k] * columns[k]
        return total

    def matrix(self, columns: ca.SX) -> ca.SX:
        """The columns in the rows of their axes (n, n_gains), sparse."""
        matrix = ca.SX(self.n, self.n_gains)
        for k, (part, _) in enumerate(self.gains):
            matrix[part.axis, k] = columns[k]
        return matrix

    def _with_states(self, state: ca.SX) -> Iterator[tuple[PlacedEffect, ca.SX]]:
        at = 0
        for part in self.parts:
            count = len(part.effect.states)
            yield part, state[at : at + count]
            at += count


def compensated(effect: Effect) -> bool:
    """Whether an effect's gains belong to p."""
    return effect.acts_on in ("torque", "drive") and not effect.feedforward


def instant(at: ca.SX, n: int) -> tuple[Signals, ...]:
    """Signals of all axes from one vector (5 n + 1,): theta, thetad, thetadd, tau, taud, time."""
    rows: dict[str, Any] = {name: at[k * n : (k + 1) * n] for k, name in enumerate(SIGNALS)}
    time = at[len(SIGNALS) * n]
    axes = tuple(
        Signals(**{name: row[i] for name, row in rows.items()}, time=time) for i in range(n)
    )
    return tuple(replace(axis, others=axes) for axis in axes)


def followers(bank: Bank, block: str) -> list[ca.Function]:
    """What an FMU needs that follows a motion sample by sample.

    <block>_effect_start(theta) -> state (n_states,)
    <block>_effect_advance(before, now, state, Ts) -> state_next: instants as in `instant`
    """
    n = bank.n
    theta, Ts = ca.SX.sym("theta", n), ca.SX.sym("Ts")
    before, now = (ca.SX.sym(name, len(SIGNALS) * n + 1) for name in ("before", "now"))
    state = ca.SX.sym("state", bank.n_states)
    state_next = bank.advance(instant(before, n), instant(now, n), state, Ts)
    return [
        ca.Function(f"{block}_effect_start", [theta], [bank.start(theta)], ["theta"], ["state"]),
        ca.Function(
            f"{block}_effect_advance",
            [before, now, state, Ts],
            [ca.cse(state_next)],
            ["before", "now", "state", "Ts"],
            ["state_next"],
        ),
    ]


def columns_function(bank: Bank, name: str) -> ca.Function:
    """name(now, state) -> columns (n_gains,)."""
    now = ca.SX.sym("now", len(SIGNALS) * bank.n + 1)
    state = ca.SX.sym("state", bank.n_states)
    columns = ca.cse(bank.columns(instant(now, bank.n), state))
    return ca.Function(name, [now, state], [columns], ["now", "state"], ["columns"])

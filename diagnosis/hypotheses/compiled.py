"""Effects as native functions: columns and states along the samples of a log."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.effects import Effect, Shape, Signals, library
from flexhex.fmus.common.effects.effect import Expr
from flexhex.fmus.common.effects.own import OwnEffect
from flexhex.numeric.rows import native
from flexhex.numeric.scan import ScanFunction, scans

Array = NDArray[np.float64]
N_SIGNAL = 6
"""theta, thetad, thetadd, tau, taud, time."""
RATE, ACCELERATION = 1, 2
TORQUES = slice(3, 5)
"""Places of a torque and its rate among them."""


@dataclass(frozen=True)
class Compiled:
    """An effect's columns, and its states if it has any, for samples of a log.

    alone: what the other axes do has no part in it, so it takes the signals of its own axis.
    by_way: its states follow the way that angles go: noise must not count as way. swings: they
    follow accelerations, which noise of angles is most of.
    slow: it goes with angle, rate and time of its axis alone, as no answer to acceleration does;
    driven: or with the reported torque.
    along: of (state, signals, shapes and time between two samples).
    moved: it goes with motion and time alone, whatever a fit makes of the torque. placed: it goes
    with the angle of its axis alone. start: states (rows, states) of motions that have long gone on
    as in signals (rows, 6) of the axis.
    """

    effect: Effect
    columns: Callable[[Array, Array, Array], list[Array]]
    along: ScanFunction | None
    alone: bool = False
    by_way: bool = False
    swings: bool = False
    slow: bool = False
    driven: bool = False
    moved: bool = False
    placed: bool = False
    start: Callable[[Array, Array], list[Array]] | None = None

    @property
    def searched(self) -> list[Shape]:
        """Nonlinear parameters that may take any value between their bounds."""
        return [s for s in self.effect.shapes if len(s.grid) > 1 and not s.whole]

    @property
    def freedom(self) -> int:
        """How many numbers a fit of it may choose: gains and shapes, whole ones too, but for those
        that may be left out."""
        shapes = [s for s in self.effect.shapes if len(s.grid) > 1 and not (s.optional or s.aside)]
        return len(self.effect.gains) + len(shapes)


def compiled(
    n: int, effects: Mapping[str, Effect] | None = None, without: frozenset[str] = frozenset()
) -> list[Compiled]:
    """The library for machines of n axes, `without` what their base model has itself."""
    listed = list((effects or library()).values())
    own = [Compiled(e, e.along, None) for e in listed if isinstance(e, OwnEffect)]
    listed = [e for e in listed if not isinstance(e, OwnEffect)]
    chosen = [e for e in listed if e.acts_on != "mechanism" and e.id not in without]
    return [*_compiled(n, tuple(chosen)), *own]


@cache
def _compiled(n: int, chosen: tuple[Effect, ...]) -> list[Compiled]:
    with_states = [effect for effect in chosen if effect.states]
    functions = [*(_columns(e, n) for e in chosen), *map(_start, with_states)]
    columns = native(functions)
    names = [effect.id for effect in with_states]
    starts = dict(zip(names, columns[len(chosen) :], strict=True))
    along = scans([_advance(effect, n) for effect in with_states]) if with_states else []
    states = dict(zip(names, along, strict=True))
    return [
        Compiled(
            e,
            c,
            states.get(e.id),
            _is_alone(e, n),
            *_follows(e, n),
            *_is_moved(e, n),
            start=starts.get(e.id),
        )
        for e, c in zip(chosen, columns, strict=False)
    ]


def signals(n: int, symbol: ca.SX) -> Signals:
    """Signals of an axis in front of those of all n axes, N_SIGNAL each."""
    each = []
    for i in range(n + 1):
        theta, thetad, thetadd, tau, taud, time = (
            symbol[N_SIGNAL * i + k] for k in range(N_SIGNAL)
        )
        each.append(Signals(theta, thetad, thetadd, tau, taud, time))
    return replace(each[0], others=tuple(each[1:]))


def _all_columns(effect: Effect, s: Signals, state: ca.SX, shape: Mapping[str, ca.SX]) -> Expr:
    """Per unit of each gain of `Effect.fitted`."""
    return ca.vertcat(effect.columns(s, state, shape), effect.aside_columns(s, shape))


def _shape(effect: Effect, symbol: ca.SX) -> dict[str, ca.SX]:
    return {shape.name: symbol[k] for k, shape in enumerate(effect.shapes)}


def _is_alone(effect: Effect, n: int) -> bool:
    """Whether neither columns nor states depend on other axes."""
    return not _depends(effect, n)[N_SIGNAL:].any()


def _is_moved(effect: Effect, n: int) -> tuple[bool, bool, bool, bool]:
    """Whether an effect on the torque depends on angle, rate and time of its axis alone; one on
    the torque or in the drive on these and the torque; on motion and time alone, of any axis; and
    on the angle of its axis alone, at that instant."""
    depends, on = _depends(effect, n), effect.acts_on == "torque"
    torques = depends.reshape(-1, N_SIGNAL)[:, TORQUES].any()
    slow, driven, placed = (
        not np.delete(depends, but).any() for but in ([0, 1, 5], [0, 1, 3, 5], [0])
    )
    driven &= on or effect.acts_on == "drive"
    return (
        bool(on and slow),
        bool(driven),
        bool(on and not torques),
        bool(on and placed and not effect.states),
    )


@cache
def _depends(effect: Effect, n: int) -> NDArray[np.bool_]:
    """Whether columns or states depend on each of the signals, of the axis and of all."""
    u, state = ca.SX.sym("u", N_SIGNAL * (n + 1)), ca.SX.sym("state", max(1, len(effect.states)))
    shape = _shape(effect, ca.SX.sym("shape", max(1, len(effect.shapes))))
    then = effect.advance(signals(n, u), signals(n, u), state, shape, ca.SX.sym("Ts"))
    outputs = ca.vertcat(_all_columns(effect, signals(n, u), state, shape), then)
    return np.array(ca.which_depends(outputs, u))


def _follows(effect: Effect, n: int) -> tuple[bool, bool]:
    """Whether states follow angles, and not accelerations; and whether they follow these."""
    if not effect.states:
        return False, False
    before, now = (ca.SX.sym(name, N_SIGNAL * (n + 1)) for name in ("before", "now"))
    state, fixed = ca.SX.sym("state", len(effect.states)), ca.SX.sym("shape", len(effect.shapes))
    u, v = signals(n, before), signals(n, now)
    then = effect.advance(u, v, state, _shape(effect, fixed), v.time - u.time)
    depends = np.array(ca.which_depends(then, ca.vertcat(before, now))).reshape(-1, N_SIGNAL)
    swings = bool(depends[:, ACCELERATION].any())
    return bool(depends[:, 0].any() and not swings), swings


def _columns(effect: Effect, n: int) -> ca.Function:
    size = N_SIGNAL * (1 if _is_alone(effect, n) else n + 1)
    u, state = ca.SX.sym("u", size), ca.SX.sym("state", max(1, len(effect.states)))
    shape = ca.SX.sym("shape", max(1, len(effect.shapes)))
    values = _all_columns(effect, signals(n, _wide(u, n)), state, _shape(effect, shape))
    return ca.Function(f"native_{effect.id}", [u, state, shape], [ca.cse(values)])


def _start(effect: Effect) -> ca.Function:
    u, fixed = ca.SX.sym("u", N_SIGNAL), ca.SX.sym("shape", max(1, len(effect.shapes)))
    first = ca.SX(effect.start(signals(0, u), _shape(effect, fixed)))
    return ca.Function(f"native_start_{effect.id}", [u, fixed], [ca.densify(first)])


def _advance(effect: Effect, n: int) -> ca.Function:
    size = N_SIGNAL * (1 if _is_alone(effect, n) else n + 1)
    before, now = ca.SX.sym("before", size), ca.SX.sym("now", size)
    state, fixed = ca.SX.sym("state", len(effect.states)), ca.SX.sym("shape", len(effect.shapes))
    a, b = (signals(n, _wide(u, n)) for u in (before, now))
    step = ca.SX.sym("Ts")
    following = effect.advance(a, b, state, _shape(effect, fixed), step)
    given = ca.vertcat(fixed, step)
    return ca.Function(f"scan_{effect.id}", [state, before, now, given], [ca.cse(following)])


def _wide(u: ca.SX, n: int) -> ca.SX:
    """Signals of all axes, zeros where nobody looks at them."""
    return ca.vertcat(u, ca.SX.zeros(N_SIGNAL * (n + 1) - u.numel()))

"""Effects that users write: an object with `gains` and `columns`, all else by default.

gains     (name, unit) of each linear parameter, or (name, unit, "positive")
columns   (axis, **shapes) to (samples, gains): torque on one axis for one of each gain, along a
          run; axis.theta, .thetad, .thetadd, .tau, .taud, .time are arrays (samples,), axis.others
          the same of all axes; shapes by their names, as numbers
shapes    (name, unit, values to try) of each other parameter; default: none
on        axes, from 1, that can have it; default: all
most      how many of it, with other shapes, one axis can have; default: 1

The diagnosis calls `columns` with arrays of numbers; FMUs are made from what the same method gives
for symbols (`traced.py`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.effects import (
    Effect,
    Experiment,
    Expr,
    Shapes,
    Signals,
    library,
)
from flexhex.fmus.common.effects.own_members import (
    NEEDED,
    axes_of,
    gains_of,
    refuse_misspelt,
    shapes_of,
)
from flexhex.fmus.common.effects.traced import AXES, function, probes, refuse_other, traced
from flexhex.fmus.common.effects.traced import NAMES as SIGNALS
from flexhex.fmus.common.errors import FlexhexError, MachineError, UsageError
from flexhex.fmus.common.user_code import (
    EFFECT_GROUP,
    error_line,
    from_file,
    from_package,
    offered,
    refuse_missing,
    split,
)

Array = NDArray[np.float64]
PROBE = 12
"""Samples at which the columns are tried first."""


class OwnEffect(Effect):
    """A user's effect, by NumPy; see `flexhex.fmus.common.effects.Effect`.

    name: how messages call it; id: the class' name in small letters; origin: how a machine file
    calls it. Raises MachineError for what is no effect, and says why; `check` tries its columns.
    """

    acts_on = "torque"
    excites = "motions along which its columns differ from those of the model"
    experiment = "motions along which their columns differ"
    spec = Experiment("random")

    def __init__(self, model: object, id: str, name: str, origin: str) -> None:
        self.name, self.id, self.title = name, id, id.replace("_", " ")
        self.origin = origin
        refuse_misspelt(model, name)
        if not re.fullmatch(r"[a-z_][a-z0-9_]*", id):
            raise MachineError(f"{name}: {id!r}: name it with letters, digits and _")
        if id in library():
            raise MachineError(f"{name}: the library has an effect {id}: give it another name")
        self.gains = tuple(gains_of(getattr(model, "gains", None), name))
        self.shapes = tuple(shapes_of(getattr(model, "shapes", ()), name))
        names = [gain.name for gain in self.gains] + [shape.name for shape in self.shapes]
        for k, own in enumerate(names):
            if own in names[:k]:
                raise MachineError(f"{name}: {own} is listed twice: rename one")
        self.on = tuple(axes_of(getattr(model, "on", ()), name))
        most = getattr(model, "most", 1)
        if not isinstance(most, int) or most < 1:
            raise MachineError(f"{name}: most = {most!r}: must be a whole number, 1 or more")
        self.most = most
        columns: Any = getattr(model, "columns", None)
        if not callable(columns):
            raise MachineError(f"{name}: no method `columns(axis, ...)`: write one")
        self._columns: Callable[..., Any] = columns

    def __eq__(self, other: object) -> bool:
        """Of the same place, with the same parameters; what the columns are stands elsewhere."""
        if not isinstance(other, OwnEffect):
            return False
        mine, theirs = ((e.origin, e.gains, e.shapes) for e in (self, other))
        return mine == theirs

    def __hash__(self) -> int:
        return hash(self.origin)

    def meets(self, axis: int, n: int, shape: Mapping[str, float]) -> bool:
        """Whether an axis can have it."""
        return not self.on or axis in self.on

    def check(self, n: int) -> None:
        """MachineError for an axis that a machine of n axes has not, and for columns that fail at
        small random signals with any shapes to try."""
        if self.on and max(self.on) > n:
            raise MachineError(f"{self.name}: on: the logs have axes 1 to {n}, not {max(self.on)}")
        self._try(n)

    def columns(self, s: Signals, state: Expr, shape: Shapes) -> Expr:
        """Columns (gains,) of symbols. MachineError where the user's work with numbers alone."""
        return traced(self._columns, s, shape, self.name)

    def function(self, shape: Shapes, n: int = AXES) -> ca.Function:
        """What FMUs are made of, for values of the shapes: columns (gains,) of the axis' signals
        and of all n axes'. MachineError where nothing can be built, which says how to mend it."""
        inputs = probes(n)
        fixed = np.array([[shape[s.name] for s in self.shapes] or [0.0]])
        (wanted,) = self.along(inputs, np.zeros((len(inputs), 1)), fixed)
        made = function(lambda s, values: self.columns(s, None, values), shape, n)
        refuse_other(made, wanted, self.name)
        return made

    def refuse_unbuilt(self) -> None:
        """MachineError, before anything is searched, where FMUs cannot have it."""
        self.function({shape.name: shape.start for shape in self.shapes})

    def along(self, inputs: Array, states: Array, fixed: Array) -> list[Array]:
        """Columns (samples, gains) along a run, as those of the library are called: signals of the
        axis (samples, 6), then of all axes; no states; values of the shapes (samples, shapes), all
        rows alike."""
        known = inputs.copy()
        known.flags.writeable = False
        first, *others = (_axis(known[:, k : k + 6]) for k in range(0, known.shape[1], 6))
        first.others = others
        values = dict(zip([s.name for s in self.shapes], map(float, fixed[0]), strict=False))
        try:
            columns = np.asarray(self._columns(first, **values), dtype=np.float64)
        except FlexhexError:
            raise
        except Exception as error:
            raise MachineError(f"{self.name}: columns: {error_line(error)}") from error
        wanted = len(inputs), len(self.gains)
        if columns.shape == wanted[:1] and wanted[1] == 1:
            columns = columns[:, None]
        if columns.shape != wanted:
            raise MachineError(
                f"{self.name}: columns returned shape {columns.shape} for {wanted[0]} samples and"
                f" {wanted[1]} gains: must be {wanted}"
            )
        if not np.isfinite(columns).all():
            place = int(np.argwhere(~np.isfinite(columns))[0][1])
            at = ", ".join(f"{n} = {v:g}" for n, v in values.items())
            raise MachineError(
                f"{self.name}: columns: that of {self.gains[place].name} is not finite"
                + (f" where {at}" if at else "")
            )
        return [np.ascontiguousarray(columns)]

    def _try(self, n: int) -> None:
        rng = np.random.default_rng(0)
        inputs = 0.3 * rng.standard_normal((PROBE, (n + 1) * len(SIGNALS)))
        for values in self.grid:
            fixed = np.tile(np.array([*values.values(), 0.0][: max(1, len(values))]), (PROBE, 1))
            (columns,) = self.along(inputs, np.zeros((PROBE, 1)), fixed)
        if not columns.any():
            raise MachineError(f"{self.name}: columns are zero for any motion")


def own_effect(text: str, option: str) -> OwnEffect:
    """The effect of `FILE.py:NAME`, or of that name in an installed package.

    option: what names it in a message. Raises UsageError for a file or name that is not there,
    MachineError for what is no effect.
    """
    place = split(text)
    if place is None:
        packages = offered(EFFECT_GROUP)
        if text not in packages:
            if text in library():
                raise UsageError(f"{option} {text}: the library has it: it is searched already")
            known = f"packages offer {', '.join(packages)}: write one of them, or"
            raise UsageError(
                f"{option} {text}: {known if packages else 'no package offers an effect: write'}"
                " FILE.py:NAME (`flexhex init effect.py` writes an example)"
            )
        return OwnEffect(from_package(packages[text], "effect"), text, f"effect {text}", text)
    file, name = place
    refuse_missing(file, text, option)
    model = from_file(file, name, NEEDED, option, "effect")
    id = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
    return OwnEffect(model, id, text, f"{file.resolve().as_posix()}:{name}")


def _axis(signals: Array) -> SimpleNamespace:
    named = {name: signals[:, k] for k, name in enumerate(SIGNALS)}
    return SimpleNamespace(**named, others=())

"""Effects that users write: an object with `gains` and `columns`, all else by default.

gains     (name, unit) of each linear parameter, or (name, unit, "positive")
columns   (axis, **shapes) to (samples, gains): torque on one axis for one of each gain, along a
          run; axis.theta, .thetad, .thetadd, .tau, .taud, .time are arrays (samples,), axis.others
          the same of all axes; shapes by their names, as numbers
shapes    (name, unit, values to try) of each other parameter; default: none
on        axes, from 1, that can have it; default: all
most      how many of it, with other shapes, one axis can have; default: 1
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.own import error_line
from flexhex.diagnosis.basemodels.own_file import from_file, refuse_missing, split
from flexhex.fmus.common.effects import Effect, Experiment, Gain, Shape, library
from flexhex.fmus.common.errors import FlexhexError, MachineError, UsageError

Array = NDArray[np.float64]
NEEDED, OPTIONAL = ("gains", "columns"), ("shapes", "on", "most")
SIGNALS = ("theta", "thetad", "thetadd", "tau", "taud", "time")
"""What is known of an axis, in the order of the search's own arrays."""
PROBE = 12
"""Samples at which the columns are tried first."""


class OwnEffect(Effect):
    """A user's effect, by NumPy; see `flexhex.fmus.common.effects.Effect`.

    name: how messages call it; id: the class' name in small letters. Raises MachineError for what
    is no effect, and says why; `check` tries its columns.
    """

    acts_on = "torque"
    excites = "motions along which its columns differ from those of the model"
    experiment = "motions along which their columns differ"
    spec = Experiment("random")

    def __init__(self, model: object, id: str, name: str) -> None:
        self.name, self.id, self.title = name, id, id.replace("_", " ")
        _refuse_misspelt(model, name)
        if id in library():
            raise MachineError(f"{name}: the library has an effect {id}: give it another name")
        self.gains = tuple(_gains(getattr(model, "gains", None), name))
        self.shapes = tuple(_shapes(getattr(model, "shapes", ()), name))
        names = [gain.name for gain in self.gains] + [shape.name for shape in self.shapes]
        for k, own in enumerate(names):
            if own in names[:k]:
                raise MachineError(f"{name}: {own} is listed twice: rename one")
        self.on = tuple(_axes(getattr(model, "on", ()), name))
        most = getattr(model, "most", 1)
        if not isinstance(most, int) or most < 1:
            raise MachineError(f"{name}: most = {most!r}: must be a whole number, 1 or more")
        self.most = most
        columns: Any = getattr(model, "columns", None)
        if not callable(columns):
            raise MachineError(f"{name}: no method `columns(axis, ...)`: write one")
        self._columns: Callable[..., Any] = columns

    def meets(self, axis: int, n: int, shape: Mapping[str, float]) -> bool:
        """Whether an axis can have it."""
        return not self.on or axis in self.on

    def check(self, n: int) -> None:
        """MachineError for an axis that a machine of n axes has not, and for columns that fail at
        small random signals with any shapes to try."""
        if self.on and max(self.on) > n:
            raise MachineError(f"{self.name}: on: the logs have axes 1 to {n}, not {max(self.on)}")
        self._try(n)

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
        for values in product(*(shape.grid for shape in self.shapes)):
            fixed = np.tile(np.array([*values, 0.0][: max(1, len(values))]), (PROBE, 1))
            (columns,) = self.along(inputs, np.zeros((PROBE, 1)), fixed)
        if not columns.any():
            raise MachineError(f"{self.name}: columns are zero for any motion")


def own_effects(texts: Sequence[str]) -> dict[str, OwnEffect]:
    """Effects of files, `FILE.py:NAME` each, by id.

    Raises UsageError for a file that is not there, MachineError for what is no effect.
    """
    effects: dict[str, OwnEffect] = {}
    for text in texts:
        place = split(text)
        if place is None:
            raise UsageError(
                f"--effect {text}: write FILE.py:NAME; `flexhex init effect.py` writes an example"
            )
        file, name = place
        refuse_missing(file, text, "--effect")
        model = from_file(file, name, NEEDED, "--effect", "effect")
        id = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
        if id in effects:
            raise UsageError(f"--effect {text}: there are two effects {id}: rename one")
        effects[id] = OwnEffect(model, id, text)
    return effects


def _axis(signals: Array) -> SimpleNamespace:
    named = {name: signals[:, k] for k, name in enumerate(SIGNALS)}
    return SimpleNamespace(**named, others=())


def _refuse_misspelt(model: object, name: str) -> None:
    there = [member for member in dir(model) if not member.startswith("_")]
    for member in there:
        close = get_close_matches(member, (*NEEDED, *OPTIONAL), 1, 0.8)
        if close and member not in (*NEEDED, *OPTIONAL) and close[0] not in there:
            raise MachineError(f"{name}: there is no member `{member}`: is it `{close[0]}`?")
    missing = [member for member in NEEDED if member not in there]
    if missing:
        raise MachineError(
            f"{name}: no `{missing[0]}`: an effect has `gains` and `columns`"
            " (`flexhex init effect.py` writes an example)"
        )


def _listed(value: Any, what: str, how: str) -> Sequence[Any]:
    plain = isinstance(value, Sequence) and not isinstance(value, str)
    if not plain or any(isinstance(v, str) or not isinstance(v, Sequence) for v in value):
        raise MachineError(f"{what} = {value!r}: write a list of {how}")
    return list(value)


def _gains(value: Any, name: str) -> list[Gain]:
    how = '(name, unit) or (name, unit, "positive")'
    gains = []
    for entry in _listed(value, f"{name}: gains", how):
        texts = all(isinstance(v, str) for v in entry)
        if not texts or len(entry) not in (2, 3) or entry[2:] not in ((), ("positive",), []):
            raise MachineError(f"{name}: gains: {entry!r}: write {how}")
        low = 0.0 if len(entry) == 3 else -math.inf
        gains.append(Gain(entry[0], entry[1], 1.0, low))
    if not gains:
        raise MachineError(f"{name}: gains is empty: list a parameter, {how}")
    return gains


def _shapes(value: Any, name: str) -> list[Shape]:
    how = '(name, unit, (values to try)), as in ("pitch", "m", (0.01, 0.02))'
    shapes = []
    for entry in _listed(value, f"{name}: shapes", how):
        try:
            own, unit, values = entry
            grid = tuple(sorted(float(v) for v in values))
            good = isinstance(own, str) and own.isidentifier() and isinstance(unit, str)
        except (TypeError, ValueError):
            good, grid = False, ()
        if not good or not grid or not all(map(math.isfinite, grid)):
            raise MachineError(f"{name}: shapes: {entry!r}: write {how}")
        shapes.append(Shape(own, unit, grid[0], grid[-1], grid[0], grid, as_is=True))
    return shapes


def _axes(value: Any, name: str) -> list[int]:
    listed = [value] if isinstance(value, int) else list(value)
    if not all(isinstance(v, int) and v >= 1 for v in listed):
        raise MachineError(f"{name}: on = {value!r}: write axes from 1 on, (1, 3)")
    return listed


def sought(own: Mapping[str, OwnEffect]) -> dict[str, Effect]:
    """The library for the mechanism, with what can stand behind the drives' reports; and the user's
    own effects."""
    return {id: effect.behind or effect for id, effect in library().items()} | dict(own)

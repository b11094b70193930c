"""Base models that users write: an object with `parameters` and `columns`, all else by default.

parameters  (name, unit, value, tolerance) of each, or (name, unit) where nothing is known;
            `d[2]` belongs to axis 2, `link_1.m` and `link_1.J` to one body
columns     (theta, thetad, thetadd), each (samples, n), to (samples, n, parameters): torques
            for one of each parameter, every sample by itself
axes        `rotary` or `linear` for each axis; default: those of the log
holds       ids of effects that the columns contain already
payload     names of the parameters that a payload changes: mass, first and second moments
complete    whether most of the torque is explained before any effect; default: False
window      smoothing window [s]; settle [s]: what is left out at the start of a run
bars        theta (samples, n) to (samples, bars, 2, 3) [m]: both ends of each straight bar of the
            machine, that of axis i first, which begins where the axis is; for `flexhex view` alone
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import POWER, Known
from flexhex.diagnosis.basemodels.columns import ColumnBase
from flexhex.diagnosis.kinds import KINDS, Kinds, absolute, kinds_of
from flexhex.diagnosis.logs import Log
from flexhex.fmus.common.effects import library
from flexhex.fmus.common.errors import FlexhexError, MachineError
from flexhex.fmus.common.user_code import error_line

Array = NDArray[np.float64]
NEEDED = ("parameters", "columns")
OPTIONAL = ("axes", "holds", "payload", "complete", "window", "settle", "bars")
PROBE = 8
"""Samples of the log at which the columns are tried first."""


class OwnBase(ColumnBase):
    """A user's model for a log like this one; see `flexhex.diagnosis.basemodels.base.Base`.

    name: how messages call it. Raises MachineError for what is no such model, and says why.
    """

    def __init__(self, model: object, name: str, log: Log) -> None:
        self.name = name
        _refuse_misspelt(model, name)
        theta = log["theta"]
        kinds = _kinds(getattr(model, "axes", None), log, name)
        linear = _parameters(getattr(model, "parameters", None), len(kinds), name)
        super().__init__(kinds, linear, theta.ts)
        columns = getattr(model, "columns", None)
        if not callable(columns):
            raise MachineError(f"{name}: no method `columns(theta, thetad, thetadd)`: write one")
        self._columns: Callable[[Array, Array, Array], Any] = columns
        self._bars: Callable[[Array], Any] | None = getattr(model, "bars", None)
        self.holds = frozenset(_holds(getattr(model, "holds", ()), name))
        self.payload = _payload(getattr(model, "payload", ()), linear, name)
        self.complete = bool(getattr(model, "complete", False))
        self.window = _seconds(model, "window", self.window, name)
        self.settle = _seconds(model, "settle", self.settle, name)
        self._try(theta.values)

    def columns(self, theta: Array, thetad: Array, thetadd: Array) -> Array:
        """Columns (samples, n, len(linear)) of the user's model. MachineError where it fails, or
        for another shape."""
        moved = [np.array(v) for v in (theta, thetad, thetadd)]
        for values in moved:
            values.flags.writeable = False
        try:
            # what is no number is named below
            with np.errstate(all="ignore"):
                columns = np.asarray(self._columns(*moved), dtype=np.float64)
        except FlexhexError:
            raise
        except Exception as error:
            raise MachineError(f"{self.name}: columns: {error_line(error)}") from error
        wanted = len(theta), self.n, len(self.linear)
        if columns.shape != wanted:
            raise MachineError(
                f"{self.name}: columns returned shape {columns.shape} for {wanted[0]} samples of"
                f" {wanted[1]} axes and {wanted[2]} parameters: must be {wanted}"
            )
        if not np.isfinite(columns).all():
            _, axis, place = np.argwhere(~np.isfinite(columns))[0]
            raise MachineError(
                f"{self.name}: columns: that of {self.linear[place].name} on axis {axis + 1} is"
                " not finite"
            )
        return columns

    def bars(self, theta: Array) -> Array | None:
        """Ends (samples, bars, 2, 3) [m] of the machine's bars; None for a model without.

        MachineError where it fails, or for another shape."""
        if self._bars is None:
            return None
        try:
            bars = np.asarray(self._bars(np.array(theta)), dtype=np.float64)
        except Exception as error:
            raise MachineError(f"{self.name}: bars: {error_line(error)}") from error
        if bars.ndim != 4 or bars.shape != (len(theta), max(bars.shape[1], self.n), 2, 3):
            raise MachineError(
                f"{self.name}: bars returned shape {bars.shape} for {len(theta)} samples: must be"
                f" ({len(theta)}, bars, 2, 3), with at least a bar for each of {self.n} axes"
            )
        return bars

    @property
    def traceable(self) -> Callable[[Any, Any, Any], Any]:
        """The user's columns as they are, which may take symbols, too."""
        return self._columns

    def _try(self, theta: Array) -> None:
        """MachineError for columns that fail at a few angles of the log, or take one sample's
        motion for another's."""
        few = theta[np.linspace(0, len(theta) - 1, PROBE).astype(int), : self.n]
        few = np.nan_to_num(few)
        rates = np.random.default_rng(0).standard_normal((2, *few.shape))
        whole, half = self.columns(few, *rates), PROBE // 2
        part = self.columns(few[:half], *rates[:, :half])
        if not np.allclose(whole[:half], part, rtol=1e-9, atol=1e-12 * np.abs(whole).max()):
            raise MachineError(
                f"{self.name}: columns of a sample change with the samples after it: use each"
                " sample's angles, rates and accelerations alone"
            )


def _refuse_misspelt(model: object, name: str) -> None:
    """MachineError for a member that is missing or nearly called as one of ours."""
    there = [member for member in dir(model) if not member.startswith("_")]
    for member in there:
        close = get_close_matches(member, (*NEEDED, *OPTIONAL), 1, 0.85)
        if close and member not in (*NEEDED, *OPTIONAL) and close[0] not in there:
            raise MachineError(f"{name}: there is no member `{member}`: is it `{close[0]}`?")
    missing = [member for member in NEEDED if member not in there]
    if missing:
        raise MachineError(
            f"{name}: no `{missing[0]}`: a base model has `parameters` and `columns`"
            " (`flexhex init base.py` writes an example)"
        )


def _kinds(axes: Any, log: Log, name: str) -> Kinds:
    width = log["theta"].width
    if axes is None:
        return tuple(map(absolute, kinds_of(log, width)))
    by_name = {kind.name: kind for kind in KINDS}
    if isinstance(axes, str) or not isinstance(axes, Sequence) or not set(axes) <= set(by_name):
        raise MachineError(
            f"{name}: axes = {axes!r}: write a list with {' or '.join(by_name)} for each axis"
        )
    if len(axes) != width:
        raise MachineError(
            f"{name}: axes: {len(axes)} listed, {log.name} has {width}: another machine?"
        )
    return tuple(by_name[axis] for axis in axes)


def _parameters(listed: Any, n: int, name: str) -> list[Known]:
    if isinstance(listed, str) or not isinstance(listed, Sequence) or not listed:
        raise MachineError(
            f"{name}: parameters = {listed!r}: write a list of (name, unit, value, tolerance)"
        )
    parameters = [_known(entry, f"{name}: parameters[{k}]", n) for k, entry in enumerate(listed)]
    names = [known.name for known in parameters]
    twice = [own for k, own in enumerate(names) if own in names[:k]]
    if twice:
        raise MachineError(f"{name}: parameters: {twice[0]} is listed twice: rename one")
    return parameters


def _known(entry: Any, where: str, n: int) -> Known:
    how = (
        "write (name, unit, value, tolerance), the tolerance as one standard deviation, or"
        " (name, unit) where nothing is known"
    )
    shape = isinstance(entry, Sequence) and not isinstance(entry, str) and len(entry) in (2, 4)
    if not shape or not all(isinstance(text, str) and text for text in entry[:2]):
        raise MachineError(f"{where} = {entry!r}: {how}")
    try:
        value, tolerance = (float(v) for v in (*entry[2:], 0.0, math.inf)[:2])
    except (TypeError, ValueError):
        raise MachineError(f"{where} = {entry!r}: value and tolerance are no numbers") from None
    if not math.isfinite(value) or not tolerance >= 0:
        raise MachineError(
            f"{where} = {entry!r}: the value must be finite, the tolerance at least 0"
        )
    name, unit = entry[:2]
    of = re.fullmatch(r"(.*)\[(\d+)\]", name)
    axis = int(of[2]) - 1 if of and "." not in name else None
    if axis is not None and not 0 <= axis < n:
        raise MachineError(f"{where}: {name} is of axis {axis + 1}, the log has 1 to {n}")
    group = of[1] if of and axis is not None else name
    return Known(name, unit, value, tolerance, group, axis)


def _holds(ids: Any, name: str) -> list[str]:
    listed = [ids] if isinstance(ids, str) else list(ids)
    strange = [str(id) for id in listed if id not in library()]
    if strange:
        close = get_close_matches(strange[0], library(), 3, 0.0)
        raise MachineError(
            f"{name}: holds: no effect {strange[0]!r} in the library: is it {' or '.join(close)}?"
        )
    return listed


def _payload(names: Any, linear: Sequence[Known], name: str) -> tuple[int, ...]:
    listed = [names] if isinstance(names, str) else list(names)
    places = {known.name: k for k, known in enumerate(linear)}
    for one in listed:
        if one not in places:
            raise MachineError(f"{name}: payload: no parameter {one!r}: it is not in `parameters`")
        if (unit := linear[places[one]].unit) not in POWER:
            raise MachineError(
                f"{name}: payload: {one} is in {unit}: a payload changes what is in"
                f" {', '.join(POWER)}"
            )
    return tuple(places[one] for one in listed)


def _seconds(model: object, member: str, usual: float, name: str) -> float:
    value = getattr(model, member, usual)
    least = 0 if member == "settle" else 1e-6
    if not isinstance(value, int | float) or not least <= value < math.inf:
        raise MachineError(f"{name}: {member} = {value!r}: must be a time in seconds")
    return float(value)

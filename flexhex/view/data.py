"""What stands in the page: the machine's shape, angles for the bodies, lines for the plots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexhex.compare.runs import Run
from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.ssp.result import Array, Group, Result
from flexhex.tracking import SETTLE
from flexhex.view.shapes import Shape, of_machine
from flexhex.view.sources import ERROR, PAYLOAD, RESIDUAL, THETA, TORQUE, WANTED, find
from flexhex.view.thin import instants, line, packed, rows, zero_order_hold


@dataclass(frozen=True)
class Size:
    """Most of what a page holds of a run. frames: instants at which the bodies are placed, 33 Hz
    over ten minutes; values: points of all plots, which the signals share."""

    frames: int = 20_000
    values: int = 1_000_000

    def shared(self, runs: int) -> Size:
        """For each of so many runs, of which more than two are shown one at a time."""
        return Size(max(FEWEST, 2 * self.frames // max(2, runs)), 2 * self.values // max(2, runs))


FEWEST = 1000
"""Points of a line, however many lines there are."""
CHANNELS = {"e": ERROR, "tau": TORQUE, "residual": RESIDUAL, "payload": PAYLOAD}
"""What is known of the joints at an instant beside their angles."""
Span = tuple[float, float]
"""Begin and end of what is shown [s]."""


def page_data(
    runs: Sequence[Run],
    machine: Machine | Shape,
    span: Span,
    size: Size | None = None,
    **begins: Any,
) -> dict[str, Any]:
    """Everything that the page draws; numbers are base64 of little-endian float32.

    machine: a hexapod's, or what is drawn of another one. size: how much, default that of `Size`.
    begins: what the page begins with, `ghost` and `factor` as its controls call them, `plots` the
    signals.

    Raises UsageError for a machine without a platform, a run without its angles, and a span that
    no run has.
    """
    shape = of_machine(machine) if isinstance(machine, Machine) else machine
    whole, size = span, (size or Size()).shared(len(runs))
    span = _within(runs, span)
    return {
        "machine": {**shape.data, "names": shape.joints},
        "begin": span[0],
        "end": span[1],
        "settled": _settled(runs, span),
        "begins": begins,
        "runs": [
            run_data(run, shape, span if len(runs) < 3 else _within([run], whole), size)
            for run in runs
        ],
    }


def _within(runs: Sequence[Run], span: Span) -> Span:
    last = max(group.time[-1] for run in runs for group in run.result.groups.values())
    begin, end = max(0.0, span[0]), min(float(last), span[1])
    if not begin < end:
        wanted = f"--from {span[0]:g}" + (f" --to {span[1]:g}" if np.isfinite(span[1]) else "")
        raise UsageError(f"{wanted}: the run lasts from 0 to {last:g} s")
    return begin, end


def _settled(runs: Sequence[Run], span: Span) -> float:
    """Where what is judged begins [s]: the preload's transient of a loop comes before, or what no
    fit of a base model has."""
    fitted = [run.result for run in runs if RESIDUAL[0] in run.result]
    if len(fitted) == len(runs):
        shown = [np.isfinite(r[RESIDUAL[0]]).reshape(len(r[RESIDUAL[0]]), -1) for r in fitted]
        firsts = [r.time(RESIDUAL[0])[s.all(axis=1)] for r, s in zip(fitted, shown, strict=True)]
        begins = [float(first[0]) for first in firsts if len(first)]
        return min(max([span[0], *begins]), span[1])
    loops = any(ERROR[0] in run.result for run in runs)
    return SETTLE if loops and span[0] < SETTLE < span[1] else span[0]


def run_data(run: Run, shape: Shape, span: Span, size: Size) -> dict[str, Any]:
    """Frames and signals of a run."""
    return {
        "begin": span[0],
        "end": span[1],
        "name": run.name,
        "file": run.file,
        "colour": run.colour,
        "frames": frames(run, shape, span, size.frames),
        "signals": signals(run.result, span, size.values),
    }


def frames(run: Run, shape: Shape, span: Span, most: int) -> dict[str, Any]:
    """Angles [rad], tracking error r - theta [rad], torque and residual [N m] at even instants,
    (n, axes) each; payload (n,) [kg]; ends of bars (n, bars, 2, 3) [m].

    What the run does not have is null.
    """
    result = run.result
    name = find(result, THETA)
    if not name or result[name].size != shape.width * len(result[name]):
        raise UsageError(f"{run.file}: {_other(result, name, shape)}")
    times = instants(result.group(name), *span, most)
    theta = _at(result, name, times)
    channels = {key: find(result, names) for key, names in CHANNELS.items()}
    values = {key: _at(result, one, times) if one else None for key, one in channels.items()}
    wanted = find(result, WANTED)
    if values["e"] is None and wanted:
        values["e"] = _at(result, wanted, times) - theta
    if values["payload"] is not None and not values["payload"].any():
        values["payload"] = None
    bars = shape.base.bars(theta.reshape(len(times), -1)) if shape.base else None
    values |= {"theta": theta, "bars": bars}
    return {
        "t0": float(times[0]),
        "step": float(times[1] - times[0]) if len(times) > 1 else 1.0,
        "count": len(times),
        **{key: None if value is None else packed(value) for key, value in values.items()},
    }


def _other(result: Result, name: str, shape: Shape) -> str:
    """Why a run is not one of this machine."""
    if not name:
        return (
            f"has no angles ({' or '.join(THETA)}), so there is no machine to show; `flexhex plot`"
            " shows signals of any run"
        )
    count = result[name].size // max(1, len(result[name]))
    axes = f"{count} {'axis' if count == 1 else 'axes'}"
    return (
        f"has angles of {axes}, the machine {shape.data['name']} has {shape.width}: say whose log"
        " it is, --base robot.urdf, or --base axis for axes without a model"
    )


def _at(result: Result, name: str, times: Array) -> Array:
    return zero_order_hold(result.group(name), result[name], times)


def signals(result: Result, span: Span, values: int) -> list[dict[str, Any]]:
    """All signals of a run as lines, columns of an array together; at most `values` points."""
    scalars = sum(
        samples.size // max(1, len(samples))
        for group in result.groups.values()
        for samples in group.signals.values()
    )
    points = max(FEWEST, values // max(1, scalars) // 2 * 2)
    return [
        _signal(group, name, span, points)
        for group in result.groups.values()
        for name in group.signals
        if rows(group, *span)[0] < rows(group, *span)[1]
    ]


def _signal(group: Group, name: str, span: Span, points: int) -> dict[str, Any]:
    first, last = rows(group, *span)
    samples = group.signals[name][first:last].reshape(last - first, -1)
    columns = np.ascontiguousarray(samples.T)
    lines = [line(first * group.Ts, group.Ts, column, points) for column in columns]
    return {
        "name": name,
        "text": group.descriptions.get(name, ""),
        "units": group.column_units(name),
        "Ts": group.Ts,
        "columns": [column.removeprefix(name) for column in group.columns(name)],
        "lines": [
            {"t0": one.t0, "step": one.step, "bin": one.bin, "values": packed(one.values)}
            for one in lines
        ],
    }

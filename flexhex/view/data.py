"""What stands in the page: the machine's geometry, angles for the bodies, lines for the plots."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexhex.compare.runs import Run
from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.ssp.result import Array, Group, Result
from flexhex.tracking import SETTLE
from flexhex.view.sources import ERROR, PAYLOAD, THETA, TORQUE, WANTED, find
from flexhex.view.thin import held, instants, line, rows


@dataclass(frozen=True)
class Size:
    """Most of what a page holds of a run. frames: instants at which the bodies are placed, 33 Hz
    over ten minutes; values: points of all plots, which the signals share."""

    frames: int = 20_000
    values: int = 1_000_000


FEWEST = 1000
"""Points of a line, however many lines there are."""
Span = tuple[float, float]
"""Begin and end of what is shown [s]."""


def page_data(
    runs: Sequence[Run], machine: Machine, span: Span, size: Size | None = None, **begins: Any
) -> dict[str, Any]:
    """Everything that the page draws; numbers are base64 of little-endian float32.

    size: how much, default that of `Size`. begins: what the page begins with, `ghost` and
    `factor` as its controls call them, `plots` the signals.

    Raises UsageError for a machine without a platform, a run without its angles, and a span that
    no run has.
    """
    if not machine.has_platform or machine.n_arms != 6:
        raise UsageError(f"machine {machine.name!r} is no hexapod: it has no platform on six arms")
    span, size = _within(runs, span), size or Size()
    return {
        "machine": geometry(machine),
        "begin": span[0],
        "end": span[1],
        "settled": _settled(runs, span),
        "begins": begins,
        "runs": [run_data(run, machine.n_arms, span, size) for run in runs],
    }


def _within(runs: Sequence[Run], span: Span) -> Span:
    last = max(group.time[-1] for run in runs for group in run.result.groups.values())
    begin, end = max(0.0, span[0]), min(float(last), span[1])
    if not begin < end:
        raise UsageError(f"--from {span[0]:g} --to {span[1]:g}: the run lasts from 0 to {last:g} s")
    return begin, end


def _settled(runs: Sequence[Run], span: Span) -> float:
    """Where what is judged begins [s]: the preload's transient of a loop comes before."""
    loops = any(ERROR[0] in run.result for run in runs)
    return SETTLE if loops and span[0] < SETTLE < span[1] else span[0]


def geometry(machine: Machine) -> dict[str, Any]:
    """Lengths [m] and directions of the machine file, by its names."""
    platform = machine.platform
    arms = [
        {"x_B": arm.x_B, "axis": arm.axis, "u_B": arm.u_B, "r_EP": platform.r_EP[i]}
        for i, arm in enumerate(machine.arms)
    ]
    return {
        "name": machine.name,
        "L": machine.geometry.L,
        "l": platform.l,
        "x_E0": platform.x_E0,
        "c_payload": platform.end_effector.c_payload,
        "arms": arms,
    }


def run_data(run: Run, arms: int, span: Span, size: Size) -> dict[str, Any]:
    """Frames and signals of a run."""
    return {
        "name": run.name,
        "file": run.file,
        "colour": run.colour,
        "frames": frames(run, arms, span, size.frames),
        "signals": signals(run.result, span, size.values),
    }


def frames(run: Run, arms: int, span: Span, most: int) -> dict[str, Any]:
    """Angles [rad], tracking error r - theta [rad], torque [N m] at even instants, (n, 6) each;
    payload (n,) [kg].

    Error, torque and payload are null where the run does not have them.
    """
    result = run.result
    name = find(result, THETA)
    if not name or result[name].shape[1:] != (arms,):
        raise UsageError(
            f"{run.file}: has no angles of {arms} joints ({' or '.join(THETA)}), so there is no"
            " machine to show; `flexhex plot` shows signals of any run"
        )
    times = instants(result.group(name), *span, most)
    theta = _at(result, name, times)
    error, wanted, torque = (find(result, names) for names in (ERROR, WANTED, TORQUE))
    e = _at(result, error, times) if error else None
    if e is None and wanted:
        e = _at(result, wanted, times) - theta
    tau = _at(result, torque, times) if torque else None
    carried = find(result, PAYLOAD)
    payload = _at(result, carried, times) if carried else None
    return {
        "t0": float(times[0]),
        "step": float(times[1] - times[0]) if len(times) > 1 else 1.0,
        "count": len(times),
        "theta": packed(theta),
        "e": None if e is None else packed(e),
        "tau": None if tau is None else packed(tau),
        "payload": None if payload is None or not payload.any() else packed(payload),
        "torque": torque,
    }


def _at(result: Result, name: str, times: Array) -> Array:
    return held(result.group(name), result[name], times)


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
        "unit": group.units.get(name, "").split(",")[0],
        "Ts": group.Ts,
        "columns": [column.removeprefix(name) for column in group.columns(name)],
        "lines": [
            {"t0": one.t0, "step": one.step, "bin": one.bin, "values": packed(one.values)}
            for one in lines
        ],
    }


def packed(values: Array) -> str:
    """Base64 of little-endian float32, row by row."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode("ascii")

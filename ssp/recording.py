"""Recordings of the gateway as results, so that they are compared with simulations.

A recording is a measured log in CSV whose line `# signals: theta=plant.theta:1 ...` says which
signal of the system each channel is, and every how many base steps it changes. Only the cycles
in which the controller ran (`phase` 1) are signals; enabling and stopping are not simulated.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fmus.common.errors import LogError
from ssp.results import Array, Group, Result, rate_name

RUNNING = 1.0


def load_recording(path: str | Path) -> Result:
    """Read a recording. Raises LogError for a file that is none, or says too little."""
    try:
        lines = Path(path).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise LogError(f"{path}: cannot be read ({error})") from None
    head = [line[1:].partition(":") for line in lines if line.startswith("#")]
    meta = {key.strip(): value.strip() for key, _, value in head}
    rows = [line for line in lines if not line.startswith("#")]
    if "signals" not in meta or "base_step_s" not in meta or len(rows) < 3:
        raise LogError(
            f"{path}: no recording of the gateway: it has no lines `# signals:` and rows"
        )
    names, units = rows[0].split(","), rows[1].split(",")
    try:
        data = np.loadtxt(rows[2:], delimiter=",", ndmin=2)
        base = float(meta["base_step_s"])
        wanted = [word.rpartition(":") for word in meta["signals"].split()]
        plans = [(*_pair(pair), int(period)) for pair, _, period in wanted]
        data = data[data[:, names.index("phase")] == RUNNING]
        data = _held(_at_its_time(data, data[:, names.index("time")] / base))
        return _result(plans, data, (names, units), base, meta)
    except (ValueError, IndexError) as error:
        raise LogError(f"{path}: a damaged recording ({error})") from None


def _at_its_time(data: Array, steps: Array) -> Array:
    """Rows (cycles, columns), one for each base step; NaN where the clock left a cycle out."""
    place = np.rint(steps - steps[0]).astype(int)
    full = np.full((place[-1] + 1, data.shape[1]), np.nan)
    full[place] = data
    return full


def _held(data: Array) -> Array:
    """Rows (cycles, columns) with the last value in place of what was not measured or left out."""
    rows = np.arange(len(data))[:, None]
    last = np.maximum.accumulate(np.where(np.isnan(data), 0, rows), axis=0)
    return np.take_along_axis(data, last, axis=0)


def _pair(text: str) -> tuple[str, str]:
    """`theta=plant.theta` in two; ValueError when it is not."""
    channel, signal = text.split("=")
    return channel, signal


def _result(
    plans: list[tuple[str, str, int]],
    data: Array,
    head: tuple[list[str], list[str]],
    base: float,
    meta: dict[str, str],
) -> Result:
    names, units = head
    groups: dict[str, Group] = {}
    for channel, signal, period in plans:
        found = [k for k, name in enumerate(names) if name.partition("[")[0] == channel]
        found = found or [names.index(channel)]
        values = data[::period, found] if len(found) > 1 else data[::period, found[0]]
        key = rate_name(period, base)
        old = groups.get(key, Group(period, base, {}))
        groups[key] = Group(
            period, base, {**old.signals, signal: values}, {**old.units, signal: units[found[0]]}
        )
    return Result(groups, duration=len(data) * base, meta=meta)

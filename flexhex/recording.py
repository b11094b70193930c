"""Recordings of the gateway: their columns, and as results to be compared with simulations.

A recording is a measured log in CSV whose line `# signals: theta=plant.theta:1 ...` says which
signal of the system each channel is, and every how many base steps it changes. Only the cycles
in which the controller ran (`phase` 1) are signals; enabling and stopping are not simulated.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from flexhex.fmus.common.errors import LogError, unreadable
from flexhex.ssp.result import FORMAT
from flexhex.ssp.results import Array, Group, Result, load, rate_name

RUNNING = 1.0


@dataclass(frozen=True)
class Recording:
    """What a file holds. rows: (cycles, columns); meta: its `# key: value` lines."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    rows: Array
    meta: dict[str, str]

    @cached_property
    def base(self) -> float:
        """Base step [s]."""
        return float(self.meta["base_step_s"])

    def places(self, channel: str) -> list[int]:
        """Columns of `theta` are those of theta[1], theta[2] ...; ValueError without any."""
        places = [k for k, name in enumerate(self.names) if name.partition("[")[0] == channel]
        return places or [self.names.index(channel)]

    def __getitem__(self, channel: str) -> Array:
        """A channel: (cycles, n), or (cycles,) where it has one column."""
        places = self.places(channel)
        return self.rows[:, places] if len(places) > 1 else self.rows[:, places[0]]


OTHERS = "`flexhex view` and `flexhex plot` show results and logs"
"""What takes other files than recordings."""


def read_recording(path: str | Path) -> Recording:
    """Read the file. Raises LogError for one that is no recording, or a damaged one."""
    try:
        lines = Path(path).read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise LogError(unreadable(path, error)) from None
    except UnicodeDecodeError:
        raise LogError(
            f"{path}: no recording of the gateway: it is not CSV text; {OTHERS}"
        ) from None
    head = [line[1:].partition(":") for line in lines if line.startswith("#")]
    meta = {key.strip(): value.strip() for key, _, value in head}
    rows = [line for line in lines if not line.startswith("#")]
    if "signals" not in meta or "base_step_s" not in meta or len(rows) < 3:
        raise LogError(
            f"{path}: no recording of the gateway: it lacks `# signals:`, `# base_step_s:` or rows;"
            f" {OTHERS}"
        )
    try:
        data = np.loadtxt(rows[2:], delimiter=",", ndmin=2)
        recording = Recording(tuple(rows[0].split(",")), tuple(rows[1].split(",")), data, meta)
        recording.places("phase"), recording.places("time")
        if not recording.base > 0.0 or len(recording.names) != data.shape[1]:
            raise ValueError(f"{data.shape[1]} columns, {len(recording.names)} names")
    except ValueError as error:
        raise LogError(f"{path}: a damaged recording ({error})") from None
    return recording


def load_recording(path: str | Path) -> Result:
    """A recording as a result. Raises LogError for a file that is none, or says too little."""
    return as_result(path, read_recording(path))


def as_result(path: str | Path, recording: Recording) -> Result:
    """The cycles in which the controller ran, as a result that begins with the first of them.

    path: named by the LogError of a damaged one.
    """
    try:
        running = recording.rows[recording["phase"] == RUNNING]
        data = _bridged(
            _at_its_time(running, running[:, recording.places("time")[0]] / recording.base)
        )
        return _result(plans(recording.meta), data, recording)
    except (ValueError, IndexError) as error:
        raise LogError(f"{path}: a damaged recording ({error})") from None


def plans(meta: dict[str, str]) -> list[tuple[str, str, int]]:
    """Channel, signal and period in base steps of the line `# signals`; ValueError for others."""
    wanted = [word.rpartition(":") for word in meta["signals"].split()]
    return [(*_pair(pair), int(period)) for pair, _, period in wanted]


def load_run(path: str | Path) -> Result:
    """A result or a recording of the gateway. LogError for a file that is neither."""
    head = _head(path) if Path(path).suffix.lower() == ".csv" else []
    if any(line.startswith("# signals:") for line in head):
        return load_recording(path)
    if head and not any(line.startswith(("# format:", "\x89HDF")) for line in head):
        raise LogError(
            f"{path}: neither a result of flexhex simulate (`# format: {FORMAT}`) nor a recording"
            " of the gateway (`# signals: ...`); `flexhex diagnose` takes measured logs"
        )
    return load(path)


def _head(path: str | Path) -> list[str]:
    """The first line and all `#` lines that follow; none where nothing can be read."""
    head: list[str] = []
    try:
        with Path(path).open(encoding="latin-1") as file:
            for line in file:
                if head and not line.startswith("#"):
                    break
                head.append(line[:200])
    except OSError:
        pass  # `load` says why
    return head


def _at_its_time(data: Array, steps: Array) -> Array:
    """Rows (cycles, columns), one for each base step; NaN where the clock left a cycle out."""
    place = np.rint(steps - steps[0]).astype(int)
    full = np.full((place[-1] + 1, data.shape[1]), np.nan)
    full[place] = data
    return full


def _bridged(data: Array) -> Array:
    """Rows (cycles, columns) with a straight line where nothing was measured, or left out."""
    rows = np.arange(len(data))
    for column in data.T:
        gap = np.isnan(column)
        if gap.any() and not gap.all():
            column[gap] = np.interp(rows[gap], rows[~gap], column[~gap])
    return data


def _pair(text: str) -> tuple[str, str]:
    """`theta=plant.theta` in two; ValueError when it is not."""
    channel, signal = text.split("=")
    return channel, signal


def _result(plans: list[tuple[str, str, int]], data: Array, recording: Recording) -> Result:
    groups: dict[str, Group] = {}
    for channel, signal, period in plans:
        places = recording.places(channel)
        values = data[::period, places] if len(places) > 1 else data[::period, places[0]]
        key = rate_name(period, recording.base)
        old = groups.get(key, Group(period, recording.base, {}))
        groups[key] = Group(
            period,
            recording.base,
            {**old.signals, signal: values},
            {**old.units, signal: recording.units[places[0]]},
        )
    return Result(groups, duration=len(data) * recording.base, meta=recording.meta)

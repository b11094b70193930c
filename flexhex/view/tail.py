"""The newest seconds of a recording to which the gateway still adds rows."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from flexhex.fmus.common.errors import LogError, unreadable
from flexhex.recording import RUNNING, Recording, as_result, plans
from flexhex.ssp.result import Array, Result

FARTHEST = 64_000_000
"""Bytes before the end of a long file that are read at first."""


class Tail:
    """Rows of `seconds` [s] before the end of a file. count: rows that were read so far; trip: what
    ended the run, empty while it goes on."""

    def __init__(self, path: Path, seconds: float) -> None:
        """Read the head. LogError for a file that is no recording, or has no whole head yet."""
        self.path, self.seconds = path, seconds
        self.count, self.trip = 0, ""
        try:
            self._file = path.open("rb")
        except OSError as error:
            raise LogError(unreadable(path, error)) from None
        lines, self._rest = [""], b""
        while lines[-1].startswith("#") or len(lines) < 2 or lines[-2].startswith("#"):
            raw = self._file.readline()
            if not raw.endswith(b"\n"):
                raise self._none()
            lines.append(raw.decode("utf-8", errors="replace").rstrip("\n"))
        head = (line[1:].partition(":") for line in lines if line.startswith("#"))
        self.meta = {key.strip(): value.strip() for key, _, value in head}
        self.names, self.units = (tuple(line.split(",")) for line in lines[-2:])
        try:
            self.base = float(self.meta["base_step_s"])
            self._step = math.lcm(*(period for _, _, period in plans(self.meta)))
            self._time, self._phase = self.names.index("time"), self.names.index("phase")
        except (KeyError, ValueError):
            raise self._none() from None
        self._rows = np.zeros((0, len(self.names)))
        begin, size = self._file.tell(), path.stat().st_size
        if size - begin > FARTHEST:
            self._file.seek(size - FARTHEST)
            self._file.readline()

    def _none(self) -> LogError:
        return LogError(
            f"{self.path}: no recording of the gateway: its head (`# signals:`, `# base_step_s:`,"
            " names, units) is not there; start `flexhex-gateway run --record` first"
        )

    def read(self) -> None:
        """Take what was added. LogError for rows that are none."""
        *lines, self._rest = (self._rest + self._file.read()).split(b"\n")
        rows = [line for line in lines if line and not line.startswith(b"#")]
        for line in lines:
            if line.startswith(b"# trip:"):
                self.trip = line.removeprefix(b"# trip:").decode(errors="replace").strip()
        if not rows:
            return
        try:
            new = np.loadtxt(rows, delimiter=",", ndmin=2, encoding="utf-8")
            running = new[new[:, self._phase] == RUNNING]
            self._rows = np.concatenate([self._rows, running])
        except (ValueError, IndexError) as error:
            raise LogError(f"{self.path}: a damaged recording ({error})") from None
        self.count += len(running)
        if len(self._rows):
            times = self._rows[:, self._time]
            self._rows = self._rows[times >= times[-1] - self.seconds]

    def result(self) -> tuple[Result, float] | None:
        """The newest rows as a result, and its time 0 on the clock of the run [s]; None before the
        controller has run for a while.

        It begins where all rates have a sample.
        """
        rows = self._rows
        steps: Array = np.rint(rows[:, self._time] / self.base)
        whole = np.flatnonzero(steps % self._step == 0)
        if not len(whole) or len(rows) - whole[0] < 2 * self._step:
            return None
        rows = rows[whole[0] :]
        recording = Recording(self.names, self.units, rows, self.meta)
        return as_result(self.path, recording), float(rows[0, self._time])

"""A run of the gateway against emulated drives, with the events of both."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tests.gateway.cable import Cable, cable
from tests.gateway.cargo import GATEWAY, built
from tests.gateway.decoder import capturing

Event = dict[str, Any]
Process = subprocess.Popen[str]
Acts = Callable[[Process, Process], None]
"""Acts on the processes of the gateway and of the drives."""
Rows = npt.NDArray[np.float64]
LIMIT_S = 240.0
"""A run that hangs is ended after this; nothing is measured with it."""


@dataclass(frozen=True)
class Ran:
    """A run of the gateway: exit code, JSON events of both sides, words, recording."""

    code: int
    events: tuple[Event, ...]
    drives: tuple[Event, ...]
    words: str
    recording: Path

    def one(self, name: str) -> Event:
        """The only event of a kind."""
        events = [e for e in self.events if e["event"] == name]
        assert len(events) == 1, f"{len(events)} events {name!r}:\n{self.words}"
        return events[0]

    def happened(self, name: str) -> list[Event]:
        """Events of a kind from the emulator."""
        return [e for e in self.drives if e["event"] == name]

    @cached_property
    def table(self) -> dict[str, Rows]:
        """Columns of the recording by name; those of six axes as (n, 6)."""
        return columns(self.recording)

    @cached_property
    def kept(self) -> dict[str, Rows]:
        """The same of the file that a trip leaves: five seconds, with the reaction."""
        return columns(Path(self.one("summary")["before_trip"]))


def columns(path: Path) -> dict[str, Rows]:
    """A recording's columns; theta[1..6] and the like become one array (n, 6)."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    data = np.loadtxt(lines[2:], delimiter=",", ndmin=2)
    table = {name: data[:, k] for k, name in enumerate(names)}
    for base in {name[:-3] for name in names if name.endswith("[6]")}:
        table[base] = np.column_stack([table[f"{base}[{k}]"] for k in range(1, 7)])
    return table


@dataclass(frozen=True)
class Bench:
    """A test set-up: system, type of drive, changes of either configuration."""

    ssp: Path
    folder: Path
    kind: str = "akd"

    def run(
        self,
        *,
        seconds: float = 2.5,
        options: str = "",
        changes: Sequence[tuple[str, str]] = (),
        command: Sequence[object] = ("run", "--enable", "--lockstep"),
        plant: Path | None = None,
        during: Callable[[subprocess.Popen[str]], None] | None = None,
        paused: Acts | None = None,
        wrapper: Sequence[object] = (),
        record: Path | None = None,
        capture: Path | None = None,
        typing: bool = False,
    ) -> Ran:
        """Run the gateway against drives with these options (TOML) and a changed configuration.

        plant: the system whose plant moves; by default the one that the gateway has.
        during: what is done to the gateway while it runs.
        paused: what is done to both processes where a fault `pause` stopped the drives' one.
        wrapper: a command that the gateway is run by.
        record: where the recording goes.
        capture: where all frames go.
        typing: `during` writes to the gateway's standard input.
        """
        program = built() / "flexhex-gateway"
        verb, *rest = command
        verbs = [verb, rest.pop(0)] if verb == "calibrate" else [verb]
        recording = record or self.folder / "run.csv"
        if recording.is_file():
            recording.unlink()
        if verb == "run":
            rest += ["--duration", seconds, "--record", recording]
        lockstep = ["--lockstep"] if "--lockstep" in rest or verb == "check" else []
        with cable() as ends, capturing(ends, capture) if capture else nullcontext():
            drives = self._drives(
                ends, program, [*lockstep, "--system", plant or self.ssp], options
            )
            try:
                words = [*wrapper, program, *verbs, self._config(changes), "--json", *rest]
                words += ["--interface", "bus1", "--ssp", self.ssp]
                gateway = subprocess.Popen(
                    ends.at(ends.gateway, words),
                    stdin=subprocess.PIPE if typing else None,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.PIPE,
                    text=True,
                )
                with killed_after(gateway):
                    if during is not None:
                        during(gateway)
                    if paused is not None and stops(drives, gateway):
                        paused(gateway, drives)
                    said, words_said = gateway.communicate(timeout=LIMIT_S)
            finally:
                drives.send_signal(signal.SIGCONT)
                drives.terminate()
                drives.wait(timeout=LIMIT_S)
                printed = self.drives_file.read_text()
        return Ran(gateway.returncode, _events(said), _events(printed), words_said, recording)

    def _drives(
        self, ends: Cable, program: Path, flags: list[object], options: str
    ) -> subprocess.Popen[str]:
        file = self.folder / "drives.toml"
        file.write_text(options)
        kind = "akd" if self.kind == "akd" else "cst"
        words = [program, "emulate", "--interface", "bus0", "--json", "--drives", kind]
        command = ends.at(ends.drives, [*words, "--options", file, *flags])
        with self.drives_file.open("w") as printed:
            drives = subprocess.Popen(command, stdout=printed, text=True)
        while drives.poll() is None and "\n" not in self.drives_file.read_text():
            time.sleep(0.001)
        first = self.drives_file.read_text().splitlines()[:1]
        assert [json.loads(line)["event"] for line in first] == ["ready"], first
        return drives

    @property
    def drives_file(self) -> Path:
        """What the drives' process prints, as it does."""
        return self.folder / "drives.jsonl"

    def _config(self, changes: Sequence[tuple[str, str]]) -> Path:
        text = (GATEWAY / "machines" / f"{self.kind}.toml").read_text()
        for old, new in changes:
            assert old in text, f"{old!r} is not in the configuration"
            text = text.replace(old, new)
        file = self.folder / "machine.toml"
        file.write_text(text)
        return file


@contextmanager
def killed_after(process: Process) -> Iterator[None]:
    """A process that is still there at the end hangs."""
    try:
        yield
    finally:
        process.kill()


def stops(drives: Process, gateway: Process) -> bool:
    """Waits until the drives' process stands still; False if the gateway ends before."""
    flags = os.WSTOPPED | os.WEXITED | os.WNOHANG | os.WNOWAIT
    while gateway.poll() is None:
        if os.waitid(os.P_PID, drives.pid, flags) is not None:
            return True
        time.sleep(0.01)
    return False


def _events(text: str) -> tuple[Event, ...]:
    return tuple(json.loads(line) for line in text.splitlines() if line.startswith("{"))


def drive(position: int, text: str) -> str:
    """Options of the emulator for one drive."""
    return f"[[drive]]\nposition = {position}\n{text}\n"


def never_enabled(ran: Ran) -> None:
    """No drive was led to power by the gateway."""
    assert not [e for e in ran.happened("drive") if e["to"] == "operation enabled"]

"""The emulated machine and the gateway on a cable: two network namespaces and a veth pair."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from flexhex.fmus.common.errors import RunError, UsageError

ROOT = Path(__file__).resolve().parents[2] / "gateway"
PROGRAM = ROOT / "target" / "release" / "flexhex-gateway"
CONFIGURATION = ROOT / "machines" / "akd.toml"
"""The configuration of the drives that are emulated: six AKD in torque mode."""
PREFIX = "flexhex-"
"""How the names of our network namespaces begin; they end in the process that made them."""
PATIENT = {
    "step_limit_us": "1000000",
    "overrun_us": "1000000",
    "watchdog_ms": "1000",
    "lost_frame_limit": "1000",
    "frozen_cycles": "4000",
    "frozen_still_cycles": "4000",
    "jump_rad": "0.05",
    "torque_step_N_m": "50.0",
}
"""Limits of that configuration which an ordinary computer does not keep, and what takes their
place: emulated drives break nothing, and the figures show what would have tripped."""
READY_S, PATIENCE_S = 20.0, 120.0
"""Time that the emulator has to begin, and that a run may take beyond its own duration."""
Event = dict[str, Any]


@dataclass(frozen=True)
class Driven:
    """A run of the gateway: its last words as events by name, its recording (CSV)."""

    summary: Event
    trip: str
    recording: Path


def check_means() -> None:
    """UsageError when a cable cannot be made here, or the gateway was not built."""
    if not PROGRAM.exists():
        raise UsageError(f"{PROGRAM}: no such program: build it by `make gateway` (wants cargo)")
    if shutil.which("ip") is None or os.geteuid() != 0:
        raise UsageError(
            "emulated drives hang on a cable between two network namespaces, which only root may"
            " make, by the command `ip` (package iproute2): run this as root"
        )


def drive(
    ssp: Path,
    seconds: float,
    recording: Path,
    lockstep: bool,
    meta: Mapping[str, object] = MappingProxyType({}),
    plant: Mapping[str, float] = MappingProxyType({}),
) -> Driven:
    """Run a .ssp on emulated drives for `seconds` [s], its own `plant` behind them.

    meta: written at the head of the recording. plant: parameters of the plant over the system's.
    Raises RunError when either side refuses, hangs or dies; a trip is a result.
    """
    step = ["--lockstep"] if lockstep else []
    emulate = [PROGRAM, "emulate", "--interface", "bus0", "--system", ssp, "--json", *step]
    emulate += ["--options", _options(recording.with_suffix(".drives.toml"), plant)]
    if not lockstep and shutil.which("chrt"):
        emulate = ["chrt", "--fifo", "70", *emulate]
    file = CONFIGURATION if lockstep else _patient(recording.with_suffix(".toml"))
    run = [PROGRAM, "run", file, "--interface", "bus1", "--ssp", ssp, "--enable", "--json"]
    recording.unlink(missing_ok=True)
    run += ["--duration", seconds, "--record", recording, *step]
    run += [word for key, value in meta.items() for word in ("--meta", f"{key}={value}")]
    with _cable() as (drives, gateway), _running(_at(drives, emulate)):
        try:
            done = subprocess.run(
                _at(gateway, run), capture_output=True, text=True, timeout=seconds + PATIENCE_S
            )
        except subprocess.TimeoutExpired:
            raise RunError(f"flexhex-gateway run: not over {PATIENCE_S:g} s late") from None
    events = {e["event"]: e for e in _events(done.stdout)}
    if "summary" not in events or "refused" in events:
        refused = events.get("refused", {}).get("message", done.stderr.strip()[-500:])
        raise RunError(f"flexhex-gateway run: {refused}")
    trip = events.get("trip", {}).get("message", "")
    return Driven(events["summary"], trip, recording)


def _options(path: Path, plant: Mapping[str, float]) -> Path:
    """Writes what is emulated: the default drives, and parameters of the plant behind them."""
    values = ", ".join(f'"plant.{name}" = {float(value)!r}' for name, value in plant.items())
    path.write_text(f"[plant]\nparameters = {{ {values} }}\n", encoding="utf-8")
    return path


def _patient(path: Path) -> Path:
    """Writes the configuration with limits that let an ordinary computer through."""
    text = CONFIGURATION.read_text(encoding="utf-8")
    for key, value in PATIENT.items():
        text = _limit(key).sub(f"{key} = {value}", text)
    path.write_text(text, encoding="utf-8")
    return path


def configured() -> dict[str, str]:
    """The limits that `PATIENT` replaces, as they stand in the configuration."""
    text = CONFIGURATION.read_text(encoding="utf-8")
    addresses: dict[str, str] = {}
    for key in PATIENT:
        values = _limit(key).findall(text)
        if len(values) != 1:
            raise RunError(f"{CONFIGURATION}: {key} stands there {len(values)} times, must be once")
        addresses[key] = values[0]
    return addresses


def _limit(key: str) -> re.Pattern[str]:
    return re.compile(rf"^{key} = ([\d.]+)", re.MULTILINE)


def wake_up_times() -> dict[str, float] | None:
    """Wake-up times of this computer at 4 kHz [us], by cyclictest; None without it."""
    if shutil.which("cyclictest") is None:
        return None
    command = "cyclictest --mlockall --priority=80 --interval=250 --loops=20000 --quiet"
    done = subprocess.run([*command.split(), "--histogram=20000"], capture_output=True, text=True)
    counts = re.findall(r"^(\d+)\s+(\d+)", done.stdout, re.MULTILINE)
    highest = re.search(r"^# Max Latencies:\s*(\d+)", done.stdout, re.MULTILINE)
    if done.returncode or not counts or not highest:
        return None
    return {**_quantiles([(float(t), int(n)) for t, n in counts]), "max": float(highest[1])}


def _quantiles(counts: Sequence[tuple[float, int]]) -> dict[str, float]:
    """p50 and p99 of a histogram, (value, count) in rising order."""
    total = sum(count for _, count in counts)
    quantiles: dict[str, float] = {}
    seen = 0
    for value, count in counts:
        seen += count
        for name, share in (("p50", 0.5), ("p99", 0.99)):
            if seen >= share * total:
                quantiles.setdefault(name, value)
    return quantiles


@contextmanager
def _cable() -> Iterator[tuple[str, str]]:
    """Names of two namespaces with the ends bus0 and bus1; removed in any case."""
    _remove_left_behind()
    names = tuple(f"{PREFIX}{end}-{os.getpid()}" for end in ("drives", "gateway"))
    drives, gateway = names
    try:
        for name in names:
            _ip("netns", "add", name)
        peer = ("type", "veth", "peer", "name", "bus1", "netns", gateway)
        _ip("link", "add", "bus0", "netns", drives, *peer)
        _ip("-n", drives, "link", "set", "bus0", "up")
        _ip("-n", gateway, "link", "set", "bus1", "up")
        yield drives, gateway
    finally:
        for name in names:
            _remove(name)


def _remove_left_behind() -> None:
    """Namespaces of runs that were killed: ours by name, and their owner is gone."""
    listed = subprocess.run(["ip", "netns", "list"], capture_output=True, text=True).stdout
    for name, owner in re.findall(rf"^({PREFIX}(?:drives|gateway)-(\d+))\b", listed, re.MULTILINE):
        if not Path("/proc", owner).exists():
            _remove(name)


def _remove(name: str) -> None:
    """A namespace, and what still runs in it: a process would keep its cable alive."""
    inside = subprocess.run(["ip", "netns", "pids", name], capture_output=True, text=True).stdout
    for process in map(int, inside.split()):
        with suppress(ProcessLookupError):
            os.kill(process, signal.SIGKILL)
    subprocess.run(["ip", "netns", "del", name], capture_output=True)


def _ip(*words: str) -> None:
    done = subprocess.run(["ip", *words], capture_output=True, text=True)
    if done.returncode:
        raise UsageError(f"ip {' '.join(words)}: {done.stderr.strip()}: is this a container?")


def _at(namespace: str, command: Sequence[object]) -> list[str]:
    return ["ip", "netns", "exec", namespace, *map(str, command)]


@contextmanager
def _running(command: list[str]) -> Iterator[None]:
    """The emulator while it runs; begins when it is ready, ended in any case."""
    emulator = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1
    )
    try:
        output = emulator.stdout
        if output is None or '"ready"' not in output.readline():
            emulator.kill()
            said = emulator.communicate(timeout=READY_S)[1].strip()
            raise RunError(f"flexhex-gateway emulate: {said[-500:] or 'ended without a word'}")
        yield
    finally:
        emulator.terminate()
        try:
            emulator.communicate(timeout=READY_S)
        except subprocess.TimeoutExpired:
            emulator.kill()
            emulator.communicate()


def _events(text: str) -> list[Event]:
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]

"""`flexhex drive`: the adaptive loop over EtherCAT frames, on emulated drives.

The gateway runs it twice: in lockstep, where it must equal the simulation, and by the clock, where
its times are measured. The recording of the second is compared and diagnosed like any log.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from diagnosis.verdict import Diagnosis
from diagnosis.workflow import Options, diagnose
from flexhex.cases import SETTLE
from flexhex.compare import Comparison, Tolerance, compare
from flexhex.drive_cable import CONFIGURATION, Driven, check_means, drive, floor
from fmus.common.errors import LogError, RunError
from fmus.common.machine_file import read_toml
from ssp.executor import run
from ssp.results import Group, Result, provenance, rate_name, save

Array = NDArray[np.float64]
SIGNALS = {
    "theta": ("plant.theta", "rad"),
    "tau_meas": ("plant.tau_meas", "N m"),
    "r": ("reference.r", "rad"),
    "tau": ("feedback.tau", "N m"),
    "e": ("feedback.e", "rad"),
}
"""Columns of a recording: the simulation's name, unit."""
RUNNING = 1.0
"""Column `phase` of the cycles in which the controller runs."""
MICRO = 1e6
NONE = "–"
Stage = Callable[[str], None]


@dataclass(frozen=True)
class Drives:
    """What came out. clock, lockstep, simulated: the runs' signals; floor: cyclictest's [us]."""

    driven: dict[str, Driven]
    results: dict[str, Result]
    comparisons: dict[str, Comparison]
    found: Diagnosis
    floor: dict[str, float] | None
    written: tuple[Path, ...]

    @property
    def good(self) -> bool:
        """Whether lockstep was the simulation, and nothing tripped."""
        tripped = any(driven.trip for driven in self.driven.values())
        return self.comparisons["lockstep"].equal and not tripped


def drives(machine_file: Path, ssp: Path, seconds: float, out: Path, stage: Stage) -> Drives:
    """Run `ssp` in lockstep, by the clock and simulated; write all to `out`.

    Raises UsageError where it cannot run at all, RunError when a side refuses.
    """
    check_means()
    out.mkdir(parents=True, exist_ok=True)
    driven: dict[str, Driven] = {}
    for name, title in (("lockstep", "in lockstep"), ("clock", "by the clock, 4 kHz")):
        stage(f"driving {title}")
        driven[name] = drive(ssp, seconds, out / f"{name}.csv", name == "lockstep")
    stage("simulating the same")
    results = {name: recorded(d.recording) for name, d in driven.items()}
    rows = results["lockstep"].group("plant.theta")
    wanted = [signal for signal, _ in SIGNALS.values()]
    length = (rows.rows - 1) * rows.base
    results["simulated"] = run(ssp, length, signals=wanted, parameters=steps(), timing=False)
    written = [save(r, out / f"{n}.h5", provenance(run=n)) for n, r in results.items()]
    exact, near = Tolerance(rtol=0.0), Tolerance(atol=1e-4)
    comparisons = {
        "lockstep": compare(results["lockstep"], results["simulated"], exact),
        "clock": compare(results["clock"], results["simulated"], near, common=True),
    }
    stage("diagnosing the recording")
    found = diagnose([driven["clock"].recording], (), machine_file, Options(confidence=0))
    stage("measuring this computer's own floor")
    return Drives(driven, results, comparisons, found, floor(), tuple(written))


def steps() -> dict[str, float]:
    """Steps of the configured drives, as parameters of the simulation: torque, angle."""
    profile = read_toml(CONFIGURATION)["profile"]
    current = profile["scale"]["current"]
    tau = current["torque_constant_N_m_per_A"] * (current["step_mA"] * 0.001)
    theta = 2.0 * math.pi / profile["counts_per_revolution"]
    return {"plant.tau_step": tau, "feedback.tau_step": tau, "plant.theta_step": theta}


def recorded(path: Path) -> Result:
    """The cycles of a recording in which the controller ran, by the names of the simulation.

    Cycles that were left out (their number is missing) repeat the one before. LogError when the
    file is no recording.
    """
    lines = (line for line in path.open(encoding="utf-8") if not line.startswith("#"))
    names = next(lines, "").strip().split(",")
    next(lines, None)
    if not {"cycle", "phase", "theta[1]"} <= set(names):
        raise LogError(f"{path}: no recording of flexhex-gateway")
    table = np.loadtxt(lines, delimiter=",", ndmin=2)
    table = table[table[:, names.index("phase")] == RUNNING]
    if len(table) < 2:
        raise RunError(f"{path}: the controller never ran; see what the gateway said")
    cycle = table[:, names.index("cycle")].astype(np.int64)
    time = table[:, names.index("time")]
    base = float(f"{(time[-1] - time[0]) / (cycle[-1] - cycle[0]):.9g}")
    held = np.searchsorted(cycle, np.arange(cycle[0], cycle[-1] + 1), side="right") - 1
    columns = {c: [names.index(f"{c}[{k}]") for k in range(1, 7)] for c in SIGNALS}
    signals = {signal: table[held][:, columns[c]] for c, (signal, _) in SIGNALS.items()}
    group = Group(1, base, signals, dict(SIGNALS.values()))
    return Result({rate_name(1, base): group}, duration=(group.rows - 1) * base)


def error(result: Result) -> tuple[float, float]:
    """RMS over the joints and largest tracking error after the settling time [urad]."""
    e = result["feedback.e"][result.time("feedback.e") > SETTLE]
    if e.size == 0:
        return math.nan, math.nan
    return MICRO * float(np.sqrt(np.mean(e**2))), MICRO * float(np.abs(e).max())


def rows(found: Drives) -> list[dict[str, Any]]:
    """One row a run: errors [urad], times [us] as p50 / p99 / max, frames."""
    listed = []
    for name, title in (("clock", "by the clock"), ("lockstep", "lockstep")):
        said = found.driven[name].summary
        times = {k: _times(said[f"{k}_us"]) for k in ("compute", "wake_up", "round_trip")}
        listed.append(_row(title, found.results[name], times, said))
    listed.append(_row("simulated", found.results["simulated"], {}, {}))
    if found.floor:
        listed.append(_row("cyclictest", None, {"wake_up": _times(found.floor)}, {}))
    return listed


def _row(
    title: str, result: Result | None, times: dict[str, str], said: dict[str, Any]
) -> dict[str, Any]:
    rms, most = error(result) if result else (math.nan, math.nan)
    return {
        "run": title,
        "e RMS [µrad]": NONE if math.isnan(rms) else f"{rms:.2f}",
        "max": NONE if math.isnan(most) else f"{most:.1f}",
        "compute [µs]": times.get("compute", NONE),
        "wake-up [µs]": times.get("wake_up", NONE),
        "round trip [µs]": times.get("round_trip", NONE),
        "frames lost": str(said.get("lost", NONE)),
        "cycles left out": str(said.get("skipped", NONE)),
    }


def _times(of: dict[str, float]) -> str:
    return " / ".join(f"{of[k]:.0f}" for k in ("p50", "p99", "max"))

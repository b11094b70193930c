"""`flexhex drive`: the adaptive loop over EtherCAT frames, on emulated drives.

The gateway runs it twice: in lockstep, where it must equal the simulation, and by the clock, where
its times are measured. The recording of the second is compared and diagnosed like any log.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from diagnosis.verdict import Diagnosis
from diagnosis.workflow import Options, diagnose
from flexhex.cases import SETTLE
from flexhex.compare.results import Comparison, Tolerance, compare
from flexhex.drive.cable import CONFIGURATION, Driven, check_means, drive, floor
from fmus.common.machine_file import read_toml
from ssp.executor import run
from ssp.recording import load_recording
from ssp.results import Result, provenance, save

MICRO = 1e6
NONE = "–"
Stage = Callable[[str], None]


@dataclass(frozen=True)
class Drives:
    """What came out. clock, lockstep, simulated: the runs' signals; floor: cyclictest's [us]."""

    driven: dict[str, Driven]
    results: dict[str, Result]
    comparisons: dict[str, Comparison]
    found: dict[str, Diagnosis]
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
    results = {name: load_recording(d.recording) for name, d in driven.items()}
    wanted = [s for group in results["lockstep"].groups.values() for s in group.signals]
    length = results["lockstep"].duration
    results["simulated"] = run(ssp, length, signals=wanted, parameters=steps(), timing=False)
    written = [save(r, out / f"{n}.h5", provenance(run=n)) for n, r in results.items()]
    exact, near = Tolerance(rtol=0.0), Tolerance(atol=1e-4)
    comparisons = {
        "lockstep": compare(results["lockstep"], results["simulated"], exact, common=True),
        "clock": compare(results["clock"], results["simulated"], near, common=True),
    }
    stage("diagnosing the recordings")
    one = Options(confidence=0)
    found = {n: diagnose([d.recording], (), machine_file, one) for n, d in driven.items()}
    stage("measuring this computer's own floor")
    return Drives(driven, results, comparisons, found, floor(), tuple(written))


def steps() -> dict[str, float]:
    """Steps of the configured drives, as parameters of the simulation: torque, angle."""
    profile = read_toml(CONFIGURATION)["profile"]
    current = profile["scale"]["current"]
    tau = current["torque_constant_N_m_per_A"] * (current["step_mA"] * 0.001)
    theta = 2.0 * math.pi / profile["counts_per_revolution"]
    return {"plant.tau_step": tau, "feedback.tau_step": tau, "plant.theta_step": theta}


def error(result: Result) -> tuple[float, float]:
    """RMS over the joints and largest tracking error after the settling time [urad]."""
    e = result["feedback.e"][result.time("feedback.e") > SETTLE]
    if e.size == 0:
        return math.nan, math.nan
    return MICRO * float(np.sqrt(np.mean(e**2))), MICRO * float(np.abs(e).max())


def rows(found: Drives) -> list[dict[str, str]]:
    """A row for each figure, a column for each run: errors [urad], times [us], frames."""
    runs = {"by the clock": "clock", "lockstep": "lockstep", "simulated": "simulated"}
    said = {name: driven.summary for name, driven in found.driven.items()}
    listed = []
    for k, title in enumerate(("e RMS [µrad]", "e max [µrad]")):
        errors = {column: f"{error(found.results[name])[k]:.2f}" for column, name in runs.items()}
        listed.append({"": title, **errors, "cyclictest": NONE})
    for key, title in (
        ("compute", "compute"),
        ("wake_up", "wake-up"),
        ("round_trip", "round trip"),
    ):
        for quantile in ("p50", "p99", "max"):
            row = {"": f"{title} {quantile} [µs]"}
            for column, name in runs.items():
                times = said.get(name, {}).get(f"{key}_us")
                row[column] = f"{times[quantile]:.1f}" if times else NONE
            ours = found.floor if key == "wake_up" else None
            listed.append({**row, "cyclictest": f"{ours[quantile]:.1f}" if ours else NONE})
    for key, title in (("lost", "frames lost"), ("skipped", "cycles left out")):
        counts = {column: str(said.get(name, {}).get(key, NONE)) for column, name in runs.items()}
        listed.append({"": title, **counts, "cyclictest": NONE})
    return listed

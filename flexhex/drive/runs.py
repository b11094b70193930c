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


def errors(found: Drives) -> list[dict[str, str]]:
    """RMS and largest tracking error [µrad], a column for each run."""
    runs = {"by the clock": "clock", "in lockstep": "lockstep", "simulated": "simulated"}
    return [
        {"": title} | {run: f"{error(found.results[name])[k]:.2f}" for run, name in runs.items()}
        for k, title in enumerate(("RMS", "largest"))
    ]


def times(found: Drives) -> list[dict[str, str]]:
    """Quantiles of each part of a cycle by the clock [µs], and this computer's own floor."""
    said = found.driven["clock"].summary
    parts: list[tuple[str, dict[str, float] | None]] = [
        ("wake-up", said.get("wake_up_us")),
        ("wake-up of cyclictest", found.floor),
        ("round trip of the frame", said.get("round_trip_us")),
        ("computing", said.get("compute_us")),
    ]
    return [
        {"": title} | {q: f"{part[q]:.1f}" if part else NONE for q in ("p50", "p99", "max")}
        for title, part in parts
    ]

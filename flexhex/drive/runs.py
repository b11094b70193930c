"""`flexhex drive`: the adaptive loop over EtherCAT frames, on emulated drives.

The gateway runs it in lockstep, where it must equal the simulation, and twice by the clock, where
its times are measured. The two passes are compared and diagnosed like any logs: what does not
repeat between them is noise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flexhex.compare.results import Comparison, Tolerance, compare
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.drive.cable import (
    CONFIGURATION,
    PATIENT,
    Driven,
    check_means,
    configured,
    drive,
    wake_up_times,
)
from flexhex.fmus.common.errors import LogError
from flexhex.fmus.common.machine_file import read_toml
from flexhex.output.tables import Column, Row
from flexhex.recording import RUNNING, load_recording, read_recording
from flexhex.simulation.cases import SETTLE
from flexhex.ssp.executor import run
from flexhex.ssp.read import read_ssp
from flexhex.ssp.results import Result, provenance, save

MICRO = 1e6
QUANTILES = ("p50", "p99", "max")
LOCKSTEP, SIMULATED = "lockstep", "simulated"
PASSES = ("clock-1", "clock-2")
TITLES = {
    "clock-1": "by the clock, pass 1",
    "clock-2": "by the clock, pass 2",
    LOCKSTEP: "in lockstep",
    SIMULATED: "simulated",
}
"""Runs by the names of their files, and what they are called."""
Stage = Callable[[str], None]
ERRORS = (
    Column("run", ""),
    Column("rms", "RMS", "µrad", ".2f"),
    Column("largest", "largest", "µrad", ".2f"),
)
TIMES = (
    Column("part", ""),
    *(
        Column(f"{q}-{k}", f"{q}, pass {k + 1}", "µs", ".1f")
        for q in QUANTILES
        for k in range(len(PASSES))
    ),
)

RELAXED = (
    Column("limit", ""),
    Column("configured", CONFIGURATION.name, "", ""),
    Column("here", "here", "", ""),
    Column("seen", "largest in both passes", "", ".4g"),
)


@dataclass(frozen=True)
class Drives:
    """All runs. results: signals of the runs and of the simulation; comparisons: of lockstep and
    the first pass with it; diagnosis: of both passes by the clock, or why there is none;
    wake_up: cyclictest's quantiles [us]."""

    driven: dict[str, Driven]
    results: dict[str, Result]
    comparisons: dict[str, Comparison]
    diagnosis: Diagnosis | str
    wake_up: dict[str, float] | None
    written: tuple[Path, ...]

    @property
    def good(self) -> bool:
        """Whether lockstep was the simulation, and nothing tripped."""
        tripped = any(driven.trip for driven in self.driven.values())
        return self.comparisons[LOCKSTEP].equal and not tripped


def drives(machine_file: Path, ssp: Path, seconds: float, out: Path, stage: Stage) -> Drives:
    """Run `ssp` in lockstep, twice by the clock and simulated; write all to `out`.

    Raises UsageError where it cannot run at all, RunError when a side refuses.
    """
    check_means()
    out.mkdir(parents=True, exist_ok=True)
    driven: dict[str, Driven] = {}
    for name in (LOCKSTEP, *PASSES):
        stage(f"driving {TITLES[name]}")
        number = PASSES.index(name) + 1 if name in PASSES else 1
        meta = {"trajectory": ssp.stem, "pass": number}
        plant = other_noise(ssp, number)
        driven[name] = drive(ssp, seconds, out / f"{name}.csv", name == LOCKSTEP, meta, plant)
    stage("simulating the same")
    results = {name: load_recording(d.recording) for name, d in driven.items()}
    signals = [s for group in results[LOCKSTEP].groups.values() for s in group.signals]
    length = results[LOCKSTEP].duration
    results[SIMULATED] = run(ssp, length, signals=signals, parameters=steps(), timing=False)
    written = [save(r, out / f"{n}.h5", provenance(run=n)) for n, r in results.items()]
    exact, near = Tolerance(rtol=0.0), Tolerance(atol=1e-4)
    comparisons = {
        name: compare(results[name], results[SIMULATED], tolerance, common=True)
        for name, tolerance in ((LOCKSTEP, exact), (PASSES[0], near))
    }
    stage("diagnosing both passes")
    passes = [driven[name].recording for name in PASSES]
    diagnosis = diagnosed(passes, machine_file)
    stage("measuring the wake-up times of this computer")
    return Drives(driven, results, comparisons, diagnosis, wake_up_times(), tuple(written))


def diagnosed(passes: list[Path], machine_file: Path) -> Diagnosis | str:
    """Diagnosis of the passes, or why they cannot be diagnosed: short runs are no mistake here."""
    try:
        return diagnose(passes, (), machine_file, Options())
    except LogError as error:
        return str(error)


def other_noise(ssp: Path, number: int) -> dict[str, float]:
    """Parameters of the plant for pass `number`: noise of its own, where the plant has any.

    The first pass has the system's own, so that it can be compared with the simulation.
    """
    noisy = "seed" in read_ssp(ssp).instance("plant").fmu.variables
    return {"seed": float(number)} if noisy and number > 1 else {}


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


def errors(result: Drives) -> list[Row]:
    """RMS and largest tracking error of each run, for `ERRORS`."""
    listed: list[Row] = []
    for name, title in TITLES.items():
        rms, largest = error(result.results[name])
        listed.append({"run": title, "rms": rms, "largest": largest})
    return listed


def times(result: Drives) -> list[Row]:
    """Quantiles of the parts of a cycle by the clock, for `TIMES`: both passes, cyclictest."""
    parts = {
        "wake-up": "wake_up_us",
        "round trip of the frame": "round_trip_us",
        "computing": "compute_us",
        "all after the reply": "after_reply_us",
    }
    summaries = [result.driven[name].summary for name in PASSES]
    each = [(f"{q}-{k}", q, s) for q in QUANTILES for k, s in enumerate(summaries)]
    rows: list[Row] = [
        {"part": title, **{name: s[key][q] for name, q, s in each}} for title, key in parts.items()
    ]
    own = {q: result.wake_up[q] if result.wake_up else None for q in QUANTILES}
    cyclictest: Row = {"part": "wake-up of cyclictest"} | {
        f"{q}-{k}": own[q] if k == 0 else None for q in QUANTILES for k in range(len(PASSES))
    }
    return [rows[0], cyclictest, *rows[1:]]


def relaxed(driven: Mapping[str, Driven]) -> list[Row]:
    """Limits that the passes by the clock did not have, for `RELAXED`, and what they reached."""
    seen = [_seen(driven[name]) for name in PASSES]
    return [
        {"limit": key, "configured": value, "here": PATIENT[key],
         "seen": max((each[key] for each in seen if key in each), default=None)}
        for key, value in configured().items()
    ]  # fmt: skip


def _seen(driven: Driven) -> dict[str, float]:
    """Largest values of a run by the limit that judges them, of those that a run tells."""
    recording = read_recording(driven.recording)
    missed = recording["answered"][recording["phase"] == RUNNING] == 0
    ends = np.flatnonzero(np.diff(np.concatenate(([False], missed, [False]))))
    in_a_row = ends[1::2] - ends[::2]
    shares = driven.summary["share_of_limits"]
    return {
        "overrun_us": driven.summary["wake_up_us"]["max"],
        "lost_frame_limit": float(in_a_row.max(initial=0)),
        "jump_rad": shares.get("jump", 0.0) * float(PATIENT["jump_rad"]),
        "torque_step_N_m": shares.get("torque_step", 0.0) * float(PATIENT["torque_step_N_m"]),
    }

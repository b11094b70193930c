"""The adaptive loop over real frames against the simulation of the same system, in lockstep."""

from __future__ import annotations

import json
import math
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.diagnosis.logs.read import read_log
from flexhex.ssp.executor import run
from flexhex.ssp.results import save
from tests.gateway.bench import Bench, Process, Ran, Rows

SECONDS = 10.0
STEPS = {"akd": 3.0 * 0.001, "cia402": 9.0 * 0.001}
"""Torque of one count [N m]: 1 mA at 3 N m/A, 0.1 % of 9 N m."""
SAME = {
    "theta": "plant.theta",
    "tau_meas": "plant.tau_meas",
    "r": "reference.r",
    "tau": "feedback.tau",
    "tau_ff": "F.tau_ff",
    "e": "feedback.e",
}


@pytest.fixture(scope="module", params=["akd", pytest.param("cia402", marks=pytest.mark.slow)])
def driven(
    request: pytest.FixtureRequest, hexapod_ssp: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, Ran]:
    """Ten seconds against each kind of drive."""
    kind = str(request.param)
    bench = Bench(hexapod_ssp, tmp_path_factory.mktemp(kind), kind)
    return kind, bench.run(seconds=SECONDS)


def steps(tau_step: float) -> dict[str, float]:
    """Quantisation of a drive as parameters of the simulation."""
    theta_step = 2 * math.pi / 2**32
    taus = dict.fromkeys(("plant.tau_step", "feedback.tau_step"), tau_step)
    return {**taus, "plant.theta_step": theta_step}


def simulated(ssp: Path, tau_step: float) -> dict[str, Rows]:
    """The simulation with the steps of the drive, each signal at every base step."""
    result = run(ssp, SECONDS, signals=list(SAME.values()), parameters=steps(tau_step))
    n = round(SECONDS / 0.00025)
    repeats = {name: n // (len(result[name]) - 1) for name in SAME.values()}
    return {ours: np.repeat(result[name], repeats[name], axis=0)[:n] for ours, name in SAME.items()}


def same(ours: Rows, theirs: Rows) -> bool:
    """Equal to the last bit; -0 and 0 are different."""
    bits = [np.ascontiguousarray(values).view(np.uint64) for values in (ours, theirs)]
    return ours.shape == theirs.shape and bool(np.array_equal(*bits))


def test_gateway_over_frames_is_the_simulation_to_the_last_bit(
    driven: tuple[str, Ran], hexapod_ssp: Path
) -> None:
    kind, ran = driven
    assert ran.code == 0, ran.words
    running = ran.table["phase"] == 1
    theirs = simulated(hexapod_ssp, STEPS[kind])
    for name, values in theirs.items():
        # counts carry no sign of zero: 0 * step is +0, the plant's own may be -0
        ours = ran.table[name][running] + 0.0
        assert same(ours, values + 0.0), name
    # the comparison is of things that move, and sees one count in one sample
    assert np.ptp(theirs["theta"], axis=0).min() > 0.1
    bent = theirs["theta"].copy()
    bent[-1, 5] += 2 * math.pi / 2**32
    assert not same(ran.table["theta"][running] + 0.0, bent + 0.0)


def test_gateway_leaves_the_drives_disabled_without_a_fault(driven: tuple[str, Ran]) -> None:
    _, ran = driven
    last = {e["position"]: e for e in ran.happened("drive")}
    assert len(last) == 6
    assert all(e["to"] != "operation enabled" and e["error"] == 0 for e in last.values())
    assert not ran.happened("watchdog")
    summary = ran.one("summary")
    assert summary["cycles_to_disabled"] is not None
    assert (summary["lost"], summary["short"], summary["not_recorded"]) == (0, 0, 0)


def test_recording_is_a_measured_log_that_diagnosis_reads(driven: tuple[str, Ran]) -> None:
    _, ran = driven
    log = read_log(ran.recording)
    assert not [f for f in log.findings if f.kind == "bad-rows"]
    for channel in ("theta", "tau_meas", "r", "tau", "tau_ff"):
        assert np.array_equal(log[channel].values, ran.table[channel]), channel


def test_recording_is_compared_with_the_simulation_by_the_command(
    driven: tuple[str, Ran], hexapod_ssp: Path, tmp_path: Path
) -> None:
    kind, ran = driven
    signals = [SAME[name] for name in SAME if name != "tau"]
    result = run(hexapod_ssp, SECONDS, signals=signals, parameters=steps(STEPS[kind]))
    file = save(result, tmp_path / "simulated.h5")
    words = ["compare", str(ran.recording), str(file), "--common", "--rtol", "0", "--plots", "0"]
    done = CliRunner().invoke(app, [*words, "--json"])
    assert done.exit_code == 0, done.output
    printed = json.loads(done.output)
    assert {d["signal"] for d in printed["signals"] if d["state"] == "equal"} == set(signals)


def test_recording_is_the_same_run_after_run(hexapod_ssp: Path, tmp_path: Path) -> None:
    tables = [Bench(hexapod_ssp, tmp_path).run(seconds=1.0).table for _ in range(2)]
    for name in (*SAME, "statusword", "working_counter", "cycle"):
        assert same(tables[0][name], tables[1][name]), name


def test_emulator_that_stands_still_for_a_while_changes_nothing(
    driven: tuple[str, Ran], hexapod_ssp: Path, tmp_path: Path
) -> None:
    """A busy computer may stop it at any time; the gateway waits, as no clock applies."""
    kind, ran = driven

    def later(_: Process, drives: Process) -> None:
        time.sleep(1.0)
        drives.send_signal(signal.SIGCONT)

    options = '[[fault]]\nkind = "pause"\ncycle = 5000\n'
    bench = Bench(hexapod_ssp, tmp_path, kind)
    stalled = bench.run(seconds=SECONDS, options=options, paused=later)
    assert stalled.happened("fault")
    assert stalled.one("summary")["lost"] == 0
    for name in (*SAME, "statusword", "working_counter", "cycle"):
        assert same(stalled.table[name], ran.table[name]), name

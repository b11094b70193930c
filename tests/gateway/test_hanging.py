"""Calls of FMUs other than steps that never return, one that crashes: with and without power."""

from __future__ import annotations

import signal
import time
from pathlib import Path

import pytest

from flexhex.ssp.fmu import binary_path
from flexhex.ssp.read import read_ssp
from tests.gateway.archives import Spoil, shared_library, spoiled, with_fmu
from tests.gateway.bench import Bench, Process
from tests.gateway.fault_table import Table
from tests.gateway.test_bounded import RESTS, SILENT
from tests.gateway.test_jog import JOG
from tests.gateway.test_landing import ALL, STEP
from tests.gateway.weight import free

HANG = Path(__file__).with_name("hang.c")


def test_fmu_that_hangs_while_it_is_loaded_is_named(hexapod_ssp: Path, tmp_path: Path) -> None:
    """An exit by the ordinary way would wait for it."""
    instance = read_ssp(hexapod_ssp).instance("F")
    library = shared_library(HANG, tmp_path).read_bytes()
    bad = tmp_path / "bad.ssp"
    changes = {binary_path(instance.fmu.model): library}
    bad.write_bytes(with_fmu(hexapod_ssp.read_bytes(), instance.source, changes))
    ran = Bench(bad, tmp_path).run(command=("check",))
    assert ran.code == 3, ran.words
    assert str(ran.one("refused")["message"]).startswith("F hangs: no answer for 3 s; no drive")


@pytest.mark.parametrize("call", ["put", "get"])
def test_inputs_and_outputs_that_hang_in_a_cycle_are_named(
    call: str, hexapod_ssp: Path, tmp_path: Path
) -> None:
    bad = spoiled(hexapod_ssp, Spoil("F", RESTS // 2, call), tmp_path / "bad.ssp")
    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp, options=SILENT, seconds=1000.0)
    assert ran.code == 1, ran.words
    assert ran.one("hung")["component"] == "F"
    assert ran.one("off")["devices"] == 6


@pytest.mark.parametrize(
    ("instance", "call", "named"),
    [("F", "terminate", "one of reference, N_F, F, feedback, W, N_E"), ("K", "free", "K")],
)
def test_fmu_that_does_not_end_is_named_after_the_run_was_reported(
    instance: str, call: str, named: str, hexapod_ssp: Path, tmp_path: Path
) -> None:
    bad = spoiled(hexapod_ssp, Spoil(instance, 0, call), tmp_path / "bad.ssp")
    ran = Bench(bad, tmp_path).run(plant=hexapod_ssp, seconds=0.05)
    assert ran.code == 1, ran.words
    assert ran.one("summary")["not_disabled"] == []
    assert "done, drives disabled" in ran.words
    message = str(ran.one("refused")["message"])
    assert message.startswith(f"{named} hangs: no answer for 3 s; the run is over"), message
    assert len(ran.table["time"]) == 200, "its recording is whole"


def test_fmu_that_hangs_beside_the_loop_lands_the_machine(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """The kinematics that judges the ways of `jog`, in the thread of the keyboard."""
    spoil = Spoil("N_F-gain-ways", 60, "hang")
    bad = spoiled(hexapod_ssp, spoil, tmp_path / "bad.ssp")

    def typed(gateway: Process) -> None:
        assert gateway.stdout
        assert gateway.stdin
        assert any('"moving"' in line for line in gateway.stdout), "it has power"
        gateway.stdin.write("to 0.3,0.3,0.3,0.3,0.3,0.3\n")
        gateway.stdin.flush()
        # the end of the input would be an order, too, if anybody read it
        time.sleep(1.0)

    fallen = free(Bench(bad, tmp_path), plant=hexapod_ssp, command=JOG, during=typed, typing=True)
    ran = fallen.ran
    assert ran.code == 1, ran.words
    assert ran.one("hung")["component"] == "N_F-gain-ways"
    assert "N_F-gain-ways hangs: no answer for 3 s: the machine lands" in ran.words
    assert ran.one("summary")["not_disabled"] == []
    fallen.ends_at_rest(0)


def test_fmu_that_crashes_ends_as_a_gateway_that_is_killed(
    hexapod_ssp: Path, tmp_path: Path, falls: Table
) -> None:
    spoil = Spoil("F", STEP // 2, "crash")
    bad = spoiled(hexapod_ssp, spoil, tmp_path / "bad.ssp")
    bench = Bench(bad, tmp_path)

    def silence(gateway: Process) -> None:
        gateway.wait()
        while '"event":"silence"' not in bench.drives_file.read_text():
            time.sleep(0.01)

    fallen = free(bench, SILENT, plant=hexapod_ssp, seconds=1000.0, during=silence)
    ran = fallen.ran
    assert ran.code == -signal.SIGABRT
    assert {e["position"] for e in ran.happened("watchdog")} == set(range(6))
    assert set(fallen.stopped["drives"]) == {"fault"}
    since = int(ran.happened("silence")[0]["cycle"])
    (off,) = {e["cycle"] - since for e in ran.happened("torque_zero")}
    fallen.ends_at_rest(since)
    row = ("FMU crashes", "watchdog of the drives", "zero", since)
    falls.add(fallen.row(*row, cycles=off, unknown=ALL))

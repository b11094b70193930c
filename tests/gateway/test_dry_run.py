"""Reading without power, and drives that a program before left half-way to it."""

from __future__ import annotations

from pathlib import Path

from tests.gateway.bench import Bench, drive, never_enabled

DRY = ("run", "--dry-run", "--lockstep")
HALF_WAY = 'initial = "ready_to_switch_on"'


def test_dry_run_reads_and_computes_but_never_enables(hexapod_ssp: Path, tmp_path: Path) -> None:
    ran = Bench(hexapod_ssp, tmp_path).run(command=DRY)
    assert ran.code == 0, ran.words
    never_enabled(ran)
    assert not ran.table["tau"].any()
    assert ran.table["tau_ff"].any()
    assert len(ran.table["time"]) >= 10_000


def test_dry_run_takes_a_drive_that_is_ready_to_switch_on_back(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """A program before left it there: no power, so no reason to refuse, but it does not stay."""
    options = drive(2, HALF_WAY)
    ran = Bench(hexapod_ssp, tmp_path).run(command=DRY, options=options, seconds=0.1)
    assert ran.code == 0, ran.words
    assert [(e["from"], e["to"]) for e in ran.happened("drive") if e["position"] == 2] == [
        ("ready to switch on", "switch on disabled")
    ]
    never_enabled(ran)
    running = ran.table["phase"] == 1
    assert not ran.table["tau"].any()
    assert set(ran.table["statusword"][running][-1].astype(int) & 0x6F) == {0x40}


def test_a_drive_that_is_ready_to_switch_on_is_enabled_with_the_others(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    options = drive(2, HALF_WAY)
    ran = Bench(hexapod_ssp, tmp_path).run(options=options, seconds=0.1)
    assert ran.code == 0, ran.words
    enabled = [e["position"] for e in ran.happened("drive") if e["to"] == "operation enabled"]
    assert sorted(enabled) == list(range(6))
    # the first to be ready waits for the last with zero torque
    assert not ran.table["tau"][ran.table["phase"] == 0].any()

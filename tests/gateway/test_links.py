"""Error counters and clocks of the drives' controllers, as check, run and summary tell them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.gateway.bench import Bench, drive, never_enabled
from tests.gateway.test_readback import CHECK, PATIENT, SHORT, refusal

CLOCK = ("run", "--dry-run")
"""By the clock, as lockstep has no SYNC0. Nothing here depends on how fast this computer is."""
FREE = "drift_ppm = 9000.0\nclock_free = true"
"""After the 5000 frames of the bring-up it is off by far more than any bound below."""
NOTHING = {"invalid_frames": 0, "receive_errors": 0, "forwarded_errors": 0, "lost_links": 0}


def test_check_tells_what_was_counted_since_power_up_and_refuses_nothing(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """Each counter at its register; a full one is told as such."""
    registers = "registers = [[0x0302, 3], [0x0303, 255], [0x0308, 1], [0x0311, 2]]"
    bench = Bench(hexapod_ssp, tmp_path)
    ran = bench.run(options=drive(2, registers), command=CHECK)
    assert ran.code == 0, ran.words
    never_enabled(ran)
    links = ran.one("links")
    cable = "cable from position 2 to position 3"
    there = {"position": 2, "axis": 3, "port": 1, "cable": cable, "full": ["receive_errors"]}
    counts = {"invalid_frames": 3, "receive_errors": 255, "lost_links": 2}
    assert links["ports"][1] == NOTHING | there | counts
    assert links["ports"][0]["forwarded_errors"] == 1
    assert len(links["ports"]) == 2
    assert links["unread"] == []
    message = (
        "position 2 (axis 3), port OUT: 3 invalid frames, at least 255 receive errors (the counter "
        f"stops at 255), 2 lost links since power-up: {cable}: a loose plug"
    )
    assert message in ran.words
    assert "positions [2] passed on damaged frames since power-up" in ran.words


def test_check_says_that_no_error_was_counted(hexapod_ssp: Path, tmp_path: Path) -> None:
    """Also of a device that is no drive."""
    changes = [(f"position = {k}\n", f"position = {k + 1}\n") for k in reversed(range(2, 6))]
    options = "[drives]\nothers = [2]\n"
    bench = Bench(hexapod_ssp, tmp_path)
    ran = bench.run(options=options, command=CHECK, changes=changes)
    assert ran.code == 0, ran.words
    assert "cables: no error counted since power-up" in ran.words
    options += drive(2, "registers = [[0x0310, 1]]")
    ran = bench.run(options=options, command=CHECK, changes=changes)
    assert "position 2, port IN: 1 lost links since power-up" in ran.words
    assert ran.one("links")["ports"][0]["axis"] is None


def test_a_run_tells_the_cable_that_disturbed_it(hexapod_ssp: Path, tmp_path: Path) -> None:
    """The run goes on: three receive errors that lose no frame, on top of what there was before."""
    fault = '[[fault]]\nkind = "link_noise"\ncycle = 100\ncount = 3\nposition = 4\n'
    options = fault + drive(4, "registers = [[0x0301, 7]]")
    ran = Bench(hexapod_ssp, tmp_path).run(options=options, seconds=0.1)
    assert ran.code == 0, ran.words
    summary = ran.one("summary")
    there = {"position": 4, "axis": 5, "port": 0, "full": []}
    cable = "cable from position 3 to position 4"
    assert summary["links"] == [NOTHING | there | {"cable": cable, "receive_errors": 3}]
    assert summary["links_unread"] == []
    assert summary["clocks"] is None, "lockstep has no clocks"
    assert f"position 4 (axis 5), port IN: 3 receive errors in the run: {cable}" in ran.words


def test_a_trip_by_a_cut_cable_names_the_cable(hexapod_ssp: Path, tmp_path: Path) -> None:
    fault = '[[fault]]\nkind = "cable_cut"\ncycle = 100\nposition = 3\n'
    ran = Bench(hexapod_ssp, tmp_path).run(options=fault, seconds=1.0)
    assert (ran.code, ran.one("trip")["reason"]) == (1, "working_counter")
    summary = ran.one("summary")
    [port] = summary["links"]
    assert (port["position"], port["port"], port["lost_links"]) == (2, 1, 1)
    assert summary["links_unread"] == [3, 4, 5]
    assert "1 lost links in the run: cable from position 2 to position 3" in ran.words
    assert "error counters of positions [3, 4, 5] were not read" in ran.words


def test_clocks_settle_before_power_and_are_reported_at_the_end(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    ran = Bench(hexapod_ssp, tmp_path).run(command=CLOCK, changes=PATIENT, seconds=SHORT)
    assert not [e for e in ran.events if e["event"] == "refused"], ran.words
    clocks = ran.one("summary")["clocks"]
    assert clocks["bound_ns"] == 2500
    assert clocks["start_ns"][0] is None, "the first device follows nobody"
    assert all(abs(ns) <= 2500 for ns in clocks["start_ns"][1:])
    every = clocks["start_ns"][1:] + clocks["end_ns"][1:]
    assert clocks["largest_ns"] == max(map(abs, every))
    assert "largest difference" in ran.words


@pytest.mark.parametrize("bound", [None, 20_000])
def test_a_clock_that_does_not_follow_is_refused(
    bound: int | None, hexapod_ssp: Path, tmp_path: Path
) -> None:
    changes = [*PATIENT, ("state_timeout_ms = 5000", "state_timeout_ms = 1000")]
    if bound:
        set_bound = f"sync0_shift_us = 0\nclock_difference_ns = {bound}"
        changes.append(("sync0_shift_us = 0", set_bound))
    options = drive(2, FREE)
    message = refusal(
        Bench(hexapod_ssp, tmp_path).run(options=options, command=CLOCK, changes=changes)
    )
    assert message.startswith("axis 3, position 2: system time difference (register 0x092c) is ")
    assert f"expected at most {bound or 2500} ns either way" in message
    assert "switch the drive off and on" in message
    assert len(message.splitlines()) == 1, "the other clocks follow"

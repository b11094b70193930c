"""Messages: categories, what is always said, and texts that importers take as formats."""

from __future__ import annotations

import ctypes as ct
import os
import subprocess
import sys
from pathlib import Path

import fmpy
import pytest

from tests.adapter.slave import ERROR, OK, WARNING, Slave
from tests.adapter.toys import BASE, VR


def switch(slave: Slave, on: bool, *categories: str) -> int:
    names = (ct.c_char_p * max(len(categories), 1))(*[c.encode() for c in categories])
    return slave.call("fmi2SetDebugLogging", int(on), ct.c_size_t(len(categories)), names)


def cause_fault(slave: Slave) -> None:
    """A fault of the block, and back."""
    for u in (0.95, 0.0):
        slave.set([VR["u"]], [u])
        slave.advance(4)


def test_nothing_but_errors_is_said_by_default(running: Slave) -> None:
    cause_fault(running)
    assert running.log == []
    running.step(0.0, 1.0)
    assert [entry[:2] for entry in running.log] == [(ERROR, "logStatusError")]


def test_logging_on_says_events_and_warnings(make) -> None:
    slave = make(logging=True).initialise()
    cause_fault(slave)
    slave.call("fmi2Terminate")
    assert slave.log == [
        (OK, "logEvents", "toy instantiated (instance one)"),
        (OK, "logEvents", "initialised, 2 base steps per sample time (instance one)"),
        (WARNING, "logStatusWarning", "fault = 2 (wide) from 0.001 s on (instance one)"),
        (OK, "logEvents", "terminated (instance one)"),
    ]


def test_warning_does_not_depend_on_the_slices(make) -> None:
    logs = []
    for count in (1, 2, 4, 8):
        slave = make(logging=True).initialise()
        slave.set([VR["u"]], [0.95])
        for _ in range(8 // count):
            slave.advance(count)
        logs.append(slave.log)
    assert logs.count(logs[0]) == len(logs)
    assert len(logs[0]) == 3


def test_only_chosen_categories_are_said(running: Slave) -> None:
    assert switch(running, True, "logStatusWarning") == OK
    cause_fault(running)
    running.call("fmi2Terminate")
    assert [entry[1] for entry in running.log] == ["logStatusWarning"]


def test_logging_can_be_switched_off(make) -> None:
    slave = make(logging=True)
    assert switch(slave, False) == OK
    slave.initialise()
    assert len(slave.log) == 1


def test_all_categories_when_none_is_named(running: Slave) -> None:
    assert switch(running, True) == OK
    running.call("fmi2Terminate")
    assert [entry[1] for entry in running.log] == ["logEvents"]


def test_unknown_category_is_refused(running: Slave) -> None:
    assert switch(running, True, "logEvents", "logAll") == ERROR
    assert running.said == (
        "fmi2SetDebugLogging: no category logAll; there are logStatusError, logStatusWarning,"
        " logEvents (instance one)"
    )
    running.call("fmi2Terminate")
    assert len(running.log) == 1, "events were switched on by a refused call"


def test_categories_are_those_of_the_description(running: Slave) -> None:
    listed = [c.get("name") for c in running.binary.xml.findall("LogCategories/Category")]
    assert listed == ["logStatusError", "logStatusWarning", "logEvents"]
    for name in listed:
        assert switch(running, True, str(name)) == OK


def test_numbers_have_a_point_whatever_the_language(toy_fmu: Path, tmp_path: Path) -> None:
    """An importer that runs in German: C's printf writes a decimal comma there."""
    command = ["localedef", "-i", "de_DE", "-f", "UTF-8", str(tmp_path / "de_DE.UTF-8")]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("localedef cannot make de_DE here")
    code = """
import locale, sys
from pathlib import Path
from tests.adapter.slave import Binary, Slave
locale.setlocale(locale.LC_ALL, "de_DE.UTF-8")
assert locale.localeconv()["decimal_point"] == ","
slave = Slave(Binary(Path(sys.argv[1]), Path(sys.argv[2]))).initialise()
slave.step(0.0, 0.0004)
print(slave.said)
"""
    environment = {**os.environ, "LOCPATH": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", code, str(toy_fmu), str(tmp_path / "fmu")],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "fmi2DoStep by 0.0004 s, must be" in done.stdout, done.stdout + done.stderr


def test_name_with_format_characters_is_escaped(make) -> None:
    slave = make("50%s #r1#").initialise()
    slave.step(0.0, 1e-9)
    assert "(instance 50%%s ##r1##)" in slave.said


def test_very_long_name_is_cut_not_written_beyond_the_end(make) -> None:
    slave = make("%" * 5000).initialise()
    assert slave.step(0.0, 1e-9) == ERROR
    assert len(slave.said) < 1100


def test_fmpy_ends_at_a_step_that_is_not_whole(toy_fmu: Path) -> None:
    """At fmi2Discard it asks for the same step again, without an end."""
    step = 1.2 * BASE
    with pytest.raises(fmpy.fmi1.FMICallException, match="fmi2DoStep"):
        fmpy.simulate_fmu(str(toy_fmu), stop_time=40 * BASE, step_size=step, output_interval=step)

"""`flexhex check --results`: an FMU against what it answered when it was built."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from flexhex.check.results import check_results
from flexhex.fmugen.blocks import BLOCKS
from flexhex.fmugen.recorded import IN, OUT
from flexhex.fmus.common.errors import InterfaceError
from tests.conformity.archives import members, rebuilt, text, without, write
from tests.golden.golden import read

NAMES = (*BLOCKS, "machine")


def flexhex(*words: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "flexhex", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("name", NAMES)
def test_fmu_answers_as_when_it_was_built(fmu_dir: Path, tmp_path: Path, name: str) -> None:
    fmu = fmu_dir / f"{name}.fmu"
    deviations = check_results(fmu)
    assert deviations
    # the same binary on the same computer: to the last bit
    assert [d.output for d in deviations if d.worst != 0] == []
    (tmp_path / "out.csv").write_bytes(members(fmu)[OUT])
    rows = read(tmp_path / "out.csv")[1]
    assert len(rows) == 20
    assert (rows[:, 1:].max(axis=0) > rows[:, 1:].min(axis=0)).any(), "nothing happens"


def test_command_prints_the_worst_and_ends_with_0(toy: Path) -> None:
    done = flexhex("check", "--results", toy)
    assert done.returncode == 0, done.stderr
    assert "as when it was built" in done.stdout
    assert "integral  0, allowed" in done.stdout


def test_changed_equation_is_found(toy: Path, tmp_path: Path) -> None:
    files = members(toy)
    change = rebuilt("toy_step.c", "s->ticks += 1.0;", "s->ticks += 1.0 + 1e-7;")
    change(files)
    broken = write(tmp_path / "toy.fmu", files)
    bad = [d for d in check_results(broken) if not d.good]
    assert [d.output for d in bad] == ["ticks"]
    assert bad[0].worst == pytest.approx(19e-7, rel=1e-6)
    done = flexhex("check", "--results", broken)
    assert done.returncode == 1
    assert "1 outputs beyond tolerance" in done.stdout
    assert "BEYOND, at 0.01 s" in done.stdout


def test_last_bits_are_within_tolerance(toy: Path, tmp_path: Path) -> None:
    files = members(toy)
    rebuilt("toy_step.c", "s->ticks += 1.0;", "s->ticks += 1.0 + 4e-16;")(files)
    assert all(d.good for d in check_results(write(tmp_path / "toy.fmu", files)))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (without(IN), "carries no reference results"),
        (without("binaries/linux64/toy.so"), "has no binary for this computer"),
        (text("time,u", "time,v", IN), "reference results of v, no such variable"),
        (text("0.0005", "x", IN), "not a table of numbers"),
        (text('guid="{', 'guid="{0'), "cannot be initialised"),
    ],
)
def test_what_cannot_be_run_is_said(toy: Path, tmp_path: Path, change, says: str) -> None:
    files = members(toy)
    change(files)
    with pytest.raises(InterfaceError, match=says):
        check_results(write(tmp_path / "toy.fmu", files))


@pytest.mark.parametrize(
    ("instead", "says"),
    [
        ("for (;;) {}", "toy.fmu: the binary does not come back within 2 s"),
        ("*(volatile int *)0 = 1;", r"toy.fmu: the binary crashes \(SIGSEGV\)"),
    ],
)
def test_binary_that_hangs_or_crashes_is_said(
    toy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, instead: str, says: str
) -> None:
    monkeypatch.setattr("flexhex.check.binary.PATIENCE", 2.0)
    files = members(toy)
    rebuilt("advance.c", "advance(m, end);", f"advance(m, end); {instead}")(files)
    with pytest.raises(InterfaceError, match=says):
        check_results(write(tmp_path / "toy.fmu", files))

"""What `flexhex identify` says of the file whose values it was given."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.prepare import Options
from flexhex.identify.other import print_identified
from flexhex.init import two_links as example
from tests.flexhex.logs import two_links_logs

BASE = f"{example.__file__}:TwoLinks"


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    return two_links_logs(tmp_path_factory.mktemp("runs"))


def test_what_the_sums_say_of_the_file_stands_below_them(
    runs: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    identified = identify([Path(runs[0])], options=Options(BASE))
    sums = [one for one in identified.combinations if len(one.terms) > 1]
    shifts = [abs(one.shift) for one in sums if one.determined]
    assert shifts
    assert max(shifts) < 2
    print_identified(identified)
    shown = capsys.readouterr().out
    assert f"The file's values of the {len(shifts)} sums are within 2 of its tolerances." in shown
    assert "No body's mass is determined by itself" in shown
    off = [replace(one, file=one.file + 9 * one.tolerance) for one in sums[:1]]
    print_identified(replace(identified, combinations=(*off, *sums[1:])))
    shown = capsys.readouterr().out
    assert f"1 of {len(shifts)} sums that the file has values of is more than 2 of its" in shown


def test_exact_values_of_the_file_are_not_taken_for_what_the_runs_lack(
    runs: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    identified = identify([Path(runs[0])], options=Options(BASE))
    held = "link_1.J", "link_2.m"
    fixed = [
        replace(p, tolerance=0.0, exact=True) if p.name in held else p
        for p in identified.parameters
    ]
    print_identified(replace(identified, parameters=tuple(fixed)))
    shown = capsys.readouterr().out
    assert "2 of 11 parameters stay at the file's values, which are exact" in shown
    assert "1 of 11 parameters are not determined" in shown
    # of link_1.J + 0.16 link_2.m both are known
    assert "link_1.J +" not in shown
    assert "link_1.mc +" not in shown

"""CSV as TwinCAT Scope exports it: a head of two blocks, times above groups of channels, channels
that end early. Exports of the program itself were compared by hand; these have their form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.logs import Options, read_log
from flexhex.fmus.common.errors import LogError
from tests.compare import assert_close

Array = NDArray[np.float64]
NAMES = {"Axis 1 ActPos": "theta[1]", "Axis 1 ActTorque": "tau_meas[1]"}


def angle(t: Array) -> Array:
    return 20.0 * np.sin(6.0 * t)


def torque(t: Array) -> Array:
    return 3.0 * np.cos(5.0 * t)


def export(
    path: Path, separator: str = "\t", comma: bool = True, first: float = 0.0, times: bool = True
) -> Path:
    """Two groups: positions each 0.5 ms, torques and a counter each 2 ms. first [ms]: of the
    times."""
    fast, slow = np.arange(4000) * 0.5, np.arange(1000) * 2.0
    mark = ["Name"] * times
    names = [*mark, "Axis 1 ActPos", *mark, "Axis 1 ActTorque", "Counter"]

    def line(label: str, *values: str) -> str:
        fields, given = list[str](), list(values)
        for name in names:
            fields.append(label if name == "Name" else given.pop(0))
        return separator.join(fields)

    said = [line("Name", "Axis 1 ActPos", "Axis 1 ActTorque", "Counter")]
    said += [line("SymbolComment", "", "", ""), line("SampleTime[ms]", "0,5", "2", "2")]
    said += [line("Unit", "deg (Angle)", "N m", "(None)")]
    head = [f"Name{separator}SCOPE{separator}", f"File{separator}scope.csv"]
    head += [separator.join(["Starttime of export", "132959733843760000", "Montag", "15:56"])]
    rows = []
    for k, t in enumerate(fast):
        values = [t + first] * times + [angle(t / 1e3)]
        if k < len(slow):
            s = slow[k]
            values += [s + first] * times + [torque(s / 1e3), k]
        rows.append(separator.join(f"{value:.10g}" for value in values))
    if comma:
        rows = [row.replace(".", ",") for row in rows]
    path.write_text("\n".join([*head, "", "", *said, "", *rows, "EOF", ""]), encoding="utf-8")
    return path


@pytest.mark.parametrize(("separator", "comma"), [("\t", True), (";", True), (",", False)])
def test_each_group_of_channels_keeps_its_own_times(
    tmp_path: Path, separator: str, comma: bool
) -> None:
    log = read_log(export(tmp_path / "s.csv", separator, comma), Options(rename=NAMES))
    theta, tau = log["theta"], log["tau_meas"]
    assert (len(theta.values), len(tau.values)) == (4000, 1000)
    assert_close([theta.ts, tau.ts], [5e-4, 2e-3], rtol=1e-9)
    at = np.arange(4000) * 5e-4
    assert_close(theta.values[:, 0], np.deg2rad(angle(at)), rtol=1e-8, what="theta")
    assert_close(tau.values[:, 0], torque(np.arange(1000) * 2e-3), rtol=1e-8, what="tau_meas")
    assert any("Counter" in str(f) for f in log.findings)
    assert not any("left out" in str(f) for f in log.findings)


def test_what_cannot_be_read_says_how_to_export_it(tmp_path: Path) -> None:
    calendar = export(tmp_path / "c.csv", first=132959733843760000.0)
    with pytest.raises(LogError, match="Full Timestamp"):
        read_log(calendar, Options(rename=NAMES))
    with pytest.raises(LogError, match="Timelines"):
        read_log(export(tmp_path / "n.csv", times=False), Options(rename=NAMES))


def test_a_csv_whose_first_column_is_a_name_is_no_export(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("Name,theta[1],tau_meas[1]\ns,rad,N m\n0,1,2\n1,2,3\n")
    with pytest.raises(LogError, match="no channel `time`; it has Name"):
        read_log(path)

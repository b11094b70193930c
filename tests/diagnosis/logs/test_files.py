"""Every kind of file gives the same log; a mangled one gives a message, never a traceback."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flexhex.diagnosis.logs import Log, Options, read_log
from flexhex.fmus.common.errors import LogError
from tests.diagnosis.synthetic import (
    columns,
    motion,
    plain_csv,
    write_csv,
    write_hdf5,
    write_mat5,
    write_mat73,
)

WRITERS: dict[str, Callable[..., Path]] = {
    "log.csv": plain_csv,
    "log.h5": write_hdf5,
    "v5.mat": write_mat5,
    "v73.mat": write_mat73,
}
ANY = settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))


def kinds(log: Log) -> set[str]:
    return {finding.kind for finding in log.findings}


@pytest.mark.parametrize("name", WRITERS)
@ANY
@given(
    numbers=st.lists(
        st.floats(-1e3, 1e3, allow_nan=False, allow_subnormal=False), min_size=12, max_size=60
    ),
    n=st.integers(1, 3),
)
def test_numbers_survive_every_kind_of_file(
    name: str, tmp_path: Path, numbers: list[float], n: int
) -> None:
    rows = len(numbers) // (2 * n)
    if rows < 3:
        return
    values = np.array(numbers[: rows * 2 * n]).reshape(rows, 2 * n)
    run = {"time": np.arange(rows) * 0.5, "theta": values[:, :n], "tau_meas": values[:, n:]}
    log = read_log(WRITERS[name](tmp_path / name, run))
    # bit for bit: numbers are written so that they read back exactly
    assert np.array_equal(log.theta, run["theta"])
    assert np.array_equal(log.tau, run["tau_meas"])
    assert log.ts == 0.5


@pytest.mark.parametrize("name", WRITERS)
def test_metadata_survive_every_kind_of_file(name: str, tmp_path: Path) -> None:
    path = WRITERS[name](tmp_path / name, motion(0.1), trajectory="a", **{"pass": "2"})
    log = read_log(path)
    assert (log.trajectory, log.pass_number) == ("a", 2)


def mangled(data: bytes, cuts: list[tuple[float, int]]) -> bytes:
    """Bytes at some relative places replaced, and the rest cut at the last of them."""
    raw = bytearray(data)
    for where, byte in cuts:
        raw[int(where * (len(raw) - 1))] = byte
    return bytes(raw[: max(int(cuts[-1][0] * len(raw)), 1)]) if cuts[-1][1] % 2 else bytes(raw)


@pytest.mark.parametrize("name", WRITERS)
@ANY
@given(
    cuts=st.lists(
        st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), min_size=1, max_size=40
    )
)
def test_mangled_file_is_read_or_refused(
    name: str, tmp_path: Path, cuts: list[tuple[float, int]]
) -> None:
    path = WRITERS[name](tmp_path / name, motion(0.05))
    path.write_bytes(mangled(path.read_bytes(), cuts))
    with contextlib.suppress(LogError):
        assert np.isfinite(read_log(path).theta).all()


@ANY
@given(text=st.text(max_size=300), ending=st.sampled_from([".csv", ".h5", ".mat"]))
def test_any_text_is_refused(text: str, ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"any{ending}"
    path.write_text(text, encoding="utf-8", errors="surrogatepass")
    with pytest.raises(LogError, match=r"any\."):
        read_log(path)


def test_german_excel_is_understood(tmp_path: Path) -> None:
    names, units, values = columns(motion(0.5))
    path = write_csv(
        tmp_path / "de.csv", names, units, values, {}, ";", ",", "\r\n", bom="\ufeffsep=;\r\n"
    )
    log = read_log(path)
    assert np.array_equal(log.theta, values[:, 1:3])
    assert "conversion" in kinds(log)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
def test_utf_16_is_named(encoding: str, tmp_path: Path) -> None:
    """What Windows' editors call Unicode; with and without a mark at its beginning."""
    path = tmp_path / "log.csv"
    path.write_text("# pass: 1\ntime,theta[1],tau_meas[1]\ns,rad,N m\n0,0,0\n", encoding)
    with pytest.raises(LogError, match="is UTF-16 text: save it as CSV in UTF-8"):
        read_log(path)


def test_thousands_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "de.csv"
    path.write_text("time;theta[1];tau_meas[1]\ns;rad;N m\n" + "0,1;1.000,5;2\n" * 5)
    with pytest.raises(LogError, match=r"'1\.000,5' has a comma and a point"):
        read_log(path)


def test_data_inspector_rows_are_understood(tmp_path: Path) -> None:
    path = tmp_path / "sdi.csv"
    rows = "".join(f"{k * 0.5},{k},{k % 3}\n" for k in range(6))
    head = "time,theta[1],tau_meas[1]\nType: double,Type: double,Type: double\n"
    path.write_text(head + "Unit: s,Unit: rad,Unit: N m\n" + rows)
    assert np.array_equal(read_log(path).theta[:, 0], np.arange(6.0))


def test_ragged_rows_are_left_out_and_counted(tmp_path: Path) -> None:
    path = plain_csv(tmp_path / "a.csv", motion(0.5))
    lines = path.read_text().splitlines()
    lines[100] += ",1,2"
    lines[200] = "0.1,2"
    path.write_text("\n".join(lines))
    log = read_log(path)
    assert [f.text for f in log.findings if f.kind == "bad-rows"] == [
        "2 rows do not have 5 fields and are left out"
    ]
    assert np.flatnonzero(~log["theta"].valid).tolist() == [98, 198]


def test_time_columns_keep_their_own_rates(tmp_path: Path) -> None:
    """Torque at half the rate of the angle, with blanks below it as exporters write them."""
    run = motion(0.5)
    slow = np.full((len(run["time"]), 3), np.nan)
    half = np.column_stack([run["time"], run["tau_meas"]])[::2]
    slow[: len(half)] = half
    values = np.column_stack([run["time"], run["theta"], slow])
    names = ["time", "theta[1]", "theta[2]", "time", "tau_meas[1]", "tau_meas[2]"]
    log = read_log(
        write_csv(tmp_path / "a.csv", names, ["s", "rad", "rad", "s", "N m", "N m"], values)
    )
    assert (log["theta"].ts, log["tau_meas"].ts) == (pytest.approx(5e-4), pytest.approx(1e-3))
    assert np.array_equal(log.tau, run["tau_meas"][::2])
    assert not log.same_clock
    assert kinds(log) == {"rate", "short"}


def test_groups_of_hdf5_keep_their_own_time(tmp_path: Path) -> None:
    run, path = motion(0.5), tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        for name, step, keys in (("fast", 1, ["theta"]), ("slow", 4, ["tau_meas"])):
            group = file.create_group(name)
            for key, unit in (("time", "s"), (keys[0], {"theta": "rad"}.get(keys[0], "N m"))):
                group[key] = run[key][::step]
                group[key].attrs["unit"] = unit
    log = read_log(path)
    assert (log["theta"].ts, log["tau_meas"].ts) == (pytest.approx(5e-4), pytest.approx(2e-3))


def test_names_of_other_loggers_are_understood(tmp_path: Path) -> None:
    _, units, values = columns(motion(0.5))
    for names in (
        ["time [s]", "theta1 [rad]", "theta2 [rad]", "tau_meas(1) [N m]", "tau_meas(2) [N m]"],
        ["t (s)", "theta_1 (rad)", "theta_2 (rad)", "tau_meas_1 (Nm)", "tau_meas_2 (Nm)"],
    ):
        log = read_log(write_csv(tmp_path / "a.csv", names, None, values))
        assert np.array_equal(log.theta, values[:, 1:3])
    names = ["time", "theta[0]", "theta[1]", "M a", "M b", "speed"]
    given = Options(rename={"M a": "tau_meas[1]", "M b": "tau_meas[2]"})
    more = np.column_stack([values, values[:, 0]])
    log = read_log(write_csv(tmp_path / "b.csv", names, [*units, "m"], more), given)
    assert {"names", "extra"} <= kinds(log)

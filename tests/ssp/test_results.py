"""Results survive HDF5 bit for bit, with what made them; other files are refused."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from flexhex.fmus.common.errors import LogError
from flexhex.ssp.executor import run
from flexhex.ssp.results import Group, Result, load, provenance, save


@pytest.fixture(scope="module")
def result(ring_ssp: Path, cache: Path) -> Result:
    return run(ring_ssp, 0.09, parameters={"src.gain": 2.0}, cache=cache)


def test_result_survives_hdf5(result: Result, tmp_path: Path) -> None:
    path = save(result, tmp_path / "runs" / "r.h5", provenance(command="flexhex simulate"))
    again = load(path)
    assert list(again.groups) == list(result.groups)
    for name, group in result.groups.items():
        other = again.groups[name]
        assert (other.period, other.base) == (group.period, group.base)
        assert other.units == group.units
        assert other.descriptions == group.descriptions
        assert set(other.signals) == set(group.signals)
        for signal, values in group.signals.items():
            assert other.signals[signal].tobytes() == values.tobytes()
    assert again.times == result.times
    assert (again.duration, again.wall) == (result.duration, result.wall)


def test_meta_tells_what_made_the_result(result: Result, tmp_path: Path) -> None:
    meta = load(save(result, tmp_path / "r.h5", provenance(machine="tflex"))).meta
    assert meta["machine"] == "tflex"
    assert meta["parameter src.gain"] == 2.0
    assert len(str(meta["sha256 ssp"])) == len(str(meta["sha256 relay2.fmu"])) == 64
    assert meta["compiler"]
    assert meta["casadi"]


def test_file_is_plain_hdf5_with_units(result: Result, tmp_path: Path) -> None:
    with h5py.File(save(result, tmp_path / "r.h5"), "r") as file:
        data = file["rates/30ms/c.y"]
        assert data.shape == (4, 2)
        assert data.attrs["unit"] == "1"
        assert data.attrs["description"] == "stamp and mixed wave"
        assert file["rates/30ms"].attrs["period"] == 120


def test_broken_and_foreign_files_are_refused(result: Result, tmp_path: Path) -> None:
    good = save(result, tmp_path / "r.h5")
    cut, text, foreign = (tmp_path / n for n in ("cut.h5", "text.h5", "foreign.h5"))
    cut.write_bytes(good.read_bytes()[:-2000])
    text.write_text("time,theta")
    with h5py.File(foreign, "w") as file:
        file["x"] = 1.0
    for path, reason in (
        (tmp_path / "none.h5", "no such file"),
        (cut, "not a readable HDF5 result"),
        (text, "not a readable HDF5 result"),
        (foreign, "not a result of flexhex"),
    ):
        with pytest.raises(LogError, match=f"{path.name}: .*{reason}"):
            load(path)


def test_other_version_and_missing_part_are_refused(result: Result, tmp_path: Path) -> None:
    path = save(result, tmp_path / "r.h5")
    with h5py.File(path, "a") as file:
        del file["times"]
    with pytest.raises(LogError, match="not a readable HDF5 result"):
        load(path)
    with h5py.File(path, "a") as file:
        file.attrs["version"] = 99
    with pytest.raises(LogError, match="version 99 of the format, this program reads 1"):
        load(path)


def test_place_that_cannot_be_written_is_named(result: Result, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(LogError, match="cannot be written"):
        save(result, tmp_path / "file" / "r.h5")


def test_large_signals_are_stored_compactly_and_read_back_bit_for_bit(tmp_path: Path) -> None:
    rows = np.arange(40_000)[:, None]
    # multiples of an encoder's step; a NaN, an infinity and a negative zero among them
    theta = 1e-8 * np.round(1e7 * np.sin(rows * [1e-3, 2e-3, 3e-3]))
    theta[7], theta[8], theta[9] = np.nan, np.inf, -0.0
    signals = {"plant.theta": theta, "plant.fault": np.zeros(40_000)}
    large = Result({"0.25ms": Group(1, 2.5e-4, signals)}, duration=10.0)
    path = save(large, tmp_path / "r.h5")
    # theta, fault and time, 8 bytes each
    assert path.stat().st_size < 0.75 * 5 * 8 * 40_000
    for name, values in signals.items():
        assert load(path)[name].tobytes() == values.tobytes()
    with h5py.File(path, "r") as file:
        # gzip: what every reader of HDF5 has, unlike h5py's own lzf
        assert file["rates/0.25ms/plant.theta"].compression == "gzip"


def test_steps_of_a_current_are_stored_more_compactly_than_noise(tmp_path: Path) -> None:
    """Values of few different ones repeat as a whole, not byte by byte: a fifth of their size
    where sorted bytes take two thirds."""
    noise = np.random.default_rng(1).normal(0, 1.0, (40_000, 2))
    torque = 3e-3 * np.round(noise / 3e-2)
    stepped = Result({"0.25ms": Group(1, 2.5e-4, {"tau": torque, "e": noise})}, duration=10.0)
    path = save(stepped, tmp_path / "r.h5")
    with h5py.File(path, "r") as file:
        stored = {n: file[f"rates/0.25ms/{n}"].id.get_storage_size() for n in ("tau", "e")}
    assert stored["tau"] < 0.3 * torque.nbytes < 0.7 * noise.nbytes < stored["e"]
    assert load(path)["tau"].tobytes() == torque.tobytes()

"""`flexhex view`: what stands in the page, from which kinds of files, and what is refused."""

from __future__ import annotations

import base64
import json
import re
import sys
import tomllib
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from numpy.typing import NDArray
from typer.testing import CliRunner

from flexhex.fmus.common.errors import LogError, MachineError, UsageError
from flexhex.ssp.results import Result, save
from flexhex.view.command import view_command
from flexhex.view.thin import line
from tests.conftest import ROOT
from tests.flexhex.test_compare import BASE, result

ASSETS = ROOT / "flexhex" / "view" / "assets"
LARGEST = 3_000_000
"""Bytes of a page without its data."""
NAMES = {
    "http://www.w3.org/1999/xhtml",  # name of HTML's namespace, in three
    "https://jcgt.org/published/0007/04/01/",  # where a shader of three comes from
    "https://github.com/leeoniya/uPlot",  # where uPlot comes from, in its head
}
"""Addresses that stand in the libraries and that nothing is loaded from."""


@pytest.fixture
def app() -> typer.Typer:
    application = typer.Typer()
    application.command("view")(view_command)
    application.callback()(lambda: None)
    return application


def run_of(seconds: float = 4.0, size: float = 0.1, **meta: str) -> Result:
    """Six joints that swing by `size` [rad] with errors of 20 urad, torques of up to 1.5 N m."""
    t = np.arange(round(seconds / BASE) + 1) * BASE
    phase = np.arange(6)
    r = size * np.sin(2 * t[:, None] + phase)
    e = 20e-6 * np.cos(40 * t[:, None] + phase)
    tau = 1.5 * np.cos(2 * t[:, None] + phase)
    signals = {"plant.theta": r - e, "feedback.e": e, "plant.tau_meas": tau, "reference.r": r}
    signals["plant.fault"] = np.zeros(len(t))
    built = result(signals, meta=meta)
    return Result(built.groups, duration=seconds, meta=meta)


def shown(app: typer.Typer, folder: Path, *words: str | Path) -> str:
    """The page of a call that succeeds."""
    page = folder / "page.html"
    done = CliRunner().invoke(app, ["view", *map(str, words), "--page", str(page)])
    assert done.exit_code == 0, done.output
    return page.read_text(encoding="utf-8")


def data_of(text: str) -> dict[str, Any]:
    match = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    assert match
    data: dict[str, Any] = json.loads(match[1])
    return data


def numbers(text: str) -> NDArray[np.float32]:
    return np.frombuffer(base64.b64decode(text), "<f4")


@pytest.mark.parametrize("count", [3, 999, 1000, 1001, 4177])
@pytest.mark.parametrize("points", [2, 10, 1000])
def test_thinned_line_keeps_extremes_where_they_are(count: int, points: int) -> None:
    samples = np.random.default_rng(count).normal(size=count)
    thin = line(1.0, 0.5, samples, points)
    assert len(thin.values) <= max(points, 2)
    if thin.bin == 1:
        assert np.array_equal(thin.values, samples)
        return
    assert thin.step == thin.bin * 0.5 / 2
    bins = [samples[k : k + thin.bin] for k in range(0, count, thin.bin)]
    assert len(bins) == len(thin.values) / 2
    for part, (a, b) in zip(bins, thin.values.reshape(-1, 2), strict=True):
        assert sorted((a, b)) == [part.min(), part.max()]
        assert (a == part.min()) == (part.argmin() <= part.argmax())


def test_constant_signal_is_two_points() -> None:
    thin = line(0.0, 0.5, np.full(1000, 3.0), 100)
    assert (thin.values.tolist(), thin.step) == ([3.0, 3.0], 499.5)


def test_page_holds_angles_errors_and_torques_of_the_run(app: typer.Typer, tmp_path: Path) -> None:
    built = run_of()
    data = data_of(shown(app, tmp_path, save(built, tmp_path / "run.h5")))
    (run,) = data["runs"]
    frames = run["frames"]
    every = round(frames["step"] / BASE)
    for name, signal in (("theta", "plant.theta"), ("e", "feedback.e"), ("tau", "plant.tau_meas")):
        sent = numbers(frames[name]).reshape(frames["count"], 6)
        assert np.array_equal(sent, built[signal][::every].astype("f4"))
    theta = next(one for one in run["signals"] if one["name"] == "plant.theta")
    assert (theta["units"], theta["columns"][5]) == (["rad"] * 6, "[6]")
    drawn = numbers(theta["lines"][5]["values"])
    assert drawn.max() == np.float32(built["plant.theta"][:, 5].max())
    assert data["settled"] == 2.0, "the loop's preload settles before"
    assert data["machine"]["name"] == "tflex"


def test_part_of_a_run_keeps_its_times(app: typer.Typer, tmp_path: Path) -> None:
    built = run_of()
    path = save(built, tmp_path / "run.h5")
    data = data_of(shown(app, tmp_path, path, "--from", "1", "--to", "1.5"))
    frames = data["runs"][0]["frames"]
    assert (data["begin"], data["end"], frames["t0"]) == (1.0, 1.5, 1.0)
    first = round(1 / BASE)
    sent = numbers(frames["theta"]).reshape(-1, 6)
    assert np.array_equal(sent[0], built["plant.theta"][first].astype("f4"))
    assert frames["count"] == round(0.5 / BASE) + 1


def test_second_run_has_its_own_name_and_colour(app: typer.Typer, tmp_path: Path) -> None:
    first = save(run_of(case="adaptive", title="adaptive feedforward"), tmp_path / "a.h5")
    second = save(run_of(), tmp_path / "b.csv")
    runs = data_of(shown(app, tmp_path, first, second))["runs"]
    assert [run["name"] for run in runs] == ["adaptive feedforward", "b"]
    assert runs[0]["colour"] != runs[1]["colour"]


def test_measured_log_is_shown_without_an_error(app: typer.Typer, tmp_path: Path) -> None:
    """It has no wanted angles; one that has them shows the error r - theta."""
    t = np.arange(2000) * 1e-3
    theta, tau = 0.1 * np.sin(t[:, None] + np.arange(6)), np.cos(t[:, None] + np.arange(6))
    head = ["time", *(f"{name}[{i}]" for name in ("theta", "tau_meas", "r") for i in range(1, 7))]
    units = ["s", *["rad"] * 6, *["N m"] * 6, *["rad"] * 6]
    rows = np.column_stack([5.0 + t, theta, tau, theta + 1e-4])
    for width, error in ((13, None), (19, 1e-4)):
        path = tmp_path / "log.csv"
        np.savetxt(
            path, rows[:, :width], delimiter=",", comments="",
            header=",".join(head[:width]) + "\n" + ",".join(units[:width]),
        )  # fmt: skip
        data = data_of(shown(app, tmp_path, path))
        frames = data["runs"][0]["frames"]
        assert (data["begin"], data["settled"]) == (0.0, 0.0)
        assert np.allclose(numbers(frames["theta"]).reshape(-1, 6)[0], theta[0])
        if error is None:
            assert frames["e"] is None
        else:
            assert np.allclose(numbers(frames["e"]), error)


def test_recording_of_the_gateway_is_shown(app: typer.Typer, tmp_path: Path) -> None:
    """Only the cycles in which the controller ran."""
    channels = [f"{name}[{i}]" for name in ("theta", "e", "tau_meas") for i in range(1, 7)]
    values = np.arange(10 * 18).reshape(10, 18) * 1e-3
    lines = [
        "# base_step_s: 0.00025",
        "# signals: theta=plant.theta:1 e=feedback.e:1 tau_meas=plant.tau_meas:1",
        ",".join(["time", "phase", *channels]),
        ",".join(["s", "1", *["rad"] * 12, *["N m"] * 6]),
        *(
            ",".join([f"{k * 0.00025:.5f}", "1" if k else "0", *(f"{v:.3f}" for v in row)])
            for k, row in enumerate(values)
        ),
    ]
    path = tmp_path / "clock-1.csv"
    path.write_text("\n".join(lines) + "\n")
    frames = data_of(shown(app, tmp_path, path))["runs"][0]["frames"]
    for name, first in (("theta", 0), ("e", 6), ("tau", 12)):
        sent = numbers(frames[name]).reshape(-1, 6)
        assert np.array_equal(sent, values[1:, first : first + 6].astype("f4"))


def test_what_cannot_be_shown_is_refused(app: typer.Typer, tmp_path: Path) -> None:
    good = save(run_of(), tmp_path / "run.h5")
    bare = save(result({"plant.fault": np.zeros(9)}), tmp_path / "bare.h5")
    (tmp_path / "text.csv").write_text("a,b\n1,2\n")
    for words, kind, reason in (
        ([bare], UsageError, "has no angles"),
        ([good, "--from", "9"], UsageError, "^--from 9: the run lasts from 0 to 4 s"),
        ([good, "--from", "2", "--to", "1"], UsageError, "^--from 2 --to 1: the run lasts"),
        ([good, "--machine", "machines/tflex-actuators.toml"], UsageError, "is no hexapod"),
        ([good, "--machine", "none.toml"], MachineError, "none.toml"),
        ([tmp_path / "none.h5"], LogError, "no such file"),
        ([tmp_path], LogError, "is a folder"),
        (
            [tmp_path / "text.csv"],
            LogError,
            "text.csv: shows no run: as a result: .* as a measured",
        ),
    ):
        done = CliRunner().invoke(app, ["view", *map(str, words)])
        assert isinstance(done.exception, kind)
        assert re.search(reason, str(done.exception))


def test_reason_that_both_readers_have_is_said_once(
    app: typer.Typer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    (tmp_path / "run.parquet").touch()
    said = str(CliRunner().invoke(app, ["view", str(tmp_path / "run.parquet")]).exception)
    assert said.count("needs the package pyarrow") == 1


def test_page_names_no_address_and_is_small_without_its_data(
    app: typer.Typer, tmp_path: Path
) -> None:
    text = shown(app, tmp_path, save(run_of(), tmp_path / "run.h5"))
    bare = re.sub(r'<script type="application/json" id="data">.*?</script>', "", text, flags=re.S)
    assert len(bare.encode()) < LARGEST
    assert "default-src 'none'" in bare, "the browser is told to load nothing"
    assert set(re.findall(r"https?://[\w./-]+", bare)) <= NAMES
    assert not re.search(r"<(link|img|iframe|script)[^>]*\s(src|href)=", bare)


def test_names_of_files_cannot_end_the_script(app: typer.Typer, tmp_path: Path) -> None:
    built = run_of(seconds=0.5, title="</script><b>x")
    text = shown(app, tmp_path, save(built, tmp_path / "run.h5"))
    assert "</script><b>" not in text
    assert data_of(text)["runs"][0]["name"] == "</script><b>x"


def test_libraries_are_those_of_the_list() -> None:
    listed = tomllib.loads((ASSETS / "assets.toml").read_text(encoding="utf-8"))["library"]
    files = {file["name"]: file["sha256"] for library in listed for file in library["files"]}
    assert {path.name for path in ASSETS.iterdir()} == {*files, "assets.toml"}
    for name, wanted in files.items():
        assert sha256((ASSETS / name).read_bytes()).hexdigest() == wanted, name
    for library in listed:
        assert library["version"] in library["source"]
        assert library["licence_file"] in files
        assert library["licence"] in (ASSETS / library["licence_file"]).read_text()[:40]

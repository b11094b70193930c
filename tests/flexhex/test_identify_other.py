"""`flexhex identify` of any base model: the command, what it prints and writes."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.planning.trajectory import read_trajectory
from flexhex.diagnosis.prepare import Options
from flexhex.identify.folder import target
from flexhex.identify.other import print_identified
from flexhex.identify.page import answer
from flexhex.init import two_links as example
from tests.diagnosis.estimation import machines
from tests.flexhex.logs import two_links_logs

BASE = f"{example.__file__}:TwoLinks"
RUN = CliRunner()


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    return two_links_logs(tmp_path_factory.mktemp("runs"))


def test_terminal_shows_sums_errors_and_what_is_not_determined(runs: list[str]) -> None:
    done = RUN.invoke(app, ["identify", *runs[:2], "--held-out", runs[2], "--base", BASE])
    assert done.exit_code == 0, done.output
    for text in (
        "link_1.mc + 0.4 link_2.m",
        "F_c[1]",
        "held out: file",
        "3 of 11 parameters are not determined",
    ):
        assert text in done.stdout, text
    assert "link_2.m *" not in done.stdout
    done = RUN.invoke(app, ["identify", *runs[:2], "--base", BASE, "--all"])
    assert "link_2.m *" in done.stdout


def test_json_has_units_intervals_and_what_was_written(runs: list[str], tmp_path: Path) -> None:
    table = tmp_path / "found.csv"
    words = ["identify", *runs[:2], "--held-out", runs[2], "--base", BASE, "--json"]
    done = RUN.invoke(app, [*words, "--write", str(table)])
    assert done.exit_code == 0, done.output
    data = json.loads(done.stdout)
    (J,) = [one for one in data["parameters"] if one["name"] == "link_2.J"]
    assert J["unit"] == "kg m2"
    assert J["ci95"][0] < J["value"] < J["ci95"][1]
    assert J["file"] == 0.075
    assert J["determined"] is True
    assert set(data["relative_error"]["held_out"]) == {"1", "2"}
    assert data["written"] == [str(table)]
    rows = {row["name"]: row for row in csv.DictReader(table.open())}
    assert float(rows["link_2.J"]["value"]) == J["value"]
    assert rows["link_1.mc + 0.4 link_2.m"]["determined"] == "true"


WRONG = {
    "machine": (["--machine", "m.toml"], 2, "reads no machine file"),
    "tolerance": (["--tolerance", "mass=0.1"], 2, "reads no machine file"),
    "joints": (["--joints", "a,b"], 2, "is no robot's file"),
    "urdf": (["--write", "x.urdf"], 2, "write .csv or .json"),
    "folder": (["--write", "/proc/nowhere/x.csv"], 3, "cannot be written"),
    "next": (["--next", "x.txt"], 2, "name a file like next.csv"),
    "fmu's name": (["--fmu", "my model.fmu"], 2, "letters, digits and underscores"),
    "fmu's folder": (["--fmu", "/proc/nowhere/x.fmu"], 3, "cannot be written"),
    "nobody's folder": (["--fmu", "/proc/x.fmu"], 3, "--fmu /proc/x.fmu: cannot be written"),
    "twice": (["--held-out", "RUN"], 2, "name it once"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_options_are_said_before_anything_is_computed(name: str, runs: list[str]) -> None:
    words, code, message = WRONG[name]
    words = [runs[0] if word == "RUN" else word for word in words]
    done = RUN.invoke(app, ["identify", *runs[:2], "--base", BASE, *words])
    error = done.exception
    assert getattr(error, "exit_code", None) == code, done.output
    assert message in str(error)


def test_hexapod_refuses_what_is_for_others(runs: list[str]) -> None:
    done = RUN.invoke(app, ["identify", runs[0], "--tolerance", "mass=0.1"])
    assert "without its file's values" in str(done.exception)
    done = RUN.invoke(app, ["identify", runs[0], "--held-out", runs[1]])
    assert "not for the hexapod" in str(done.exception)
    done = RUN.invoke(app, ["identify", runs[0], "--next", "x.csv"])
    assert "not for the hexapod" in str(done.exception)
    done = RUN.invoke(app, ["identify", runs[0], "--fmu", "x.fmu"])
    assert "the hexapod has feedforward.fmu" in str(done.exception)


def test_motion_that_tells_more_is_written_and_read_back(runs: list[str], tmp_path: Path) -> None:
    file = tmp_path / "next.csv"
    words = ["identify", runs[0], "--base", BASE, "--next", str(file)]
    data = json.loads(RUN.invoke(app, [*words, "--json"]).stdout)
    assert data["written"] == [str(file)]
    shares = [one["narrower"] for one in data["next"]]
    assert shares == sorted(shares)
    assert 0 < shares[0] < 1
    assert read_trajectory(file).r.shape[1] == 2
    said = RUN.invoke(app, words).output
    assert "± 95 % now" in said
    told = " ".join(said.split())
    assert re.search(r"reference for each axis, r\[1\] to r\[2\] in rad, every \d+ ms for", told)
    assert "Run it 2 times, so that what repeats shows" in told


def test_fmu_of_what_was_found_stands_where_it_was_asked_for(
    runs: list[str], tmp_path: Path
) -> None:
    fmu = tmp_path / "new" / "links.fmu"
    done = RUN.invoke(app, ["identify", *runs[:2], "--base", BASE, "--json", "--fmu", str(fmu)])
    data = json.loads(done.stdout)
    assert data["written"] == [str(fmu)]
    described = fmpy.read_model_description(str(fmu))
    start = {v.name: v.start for v in described.modelVariables}
    (J,) = [one for one in data["parameters"] if one["name"] == "link_2.J"]
    assert float(start["p.link_2.J"]) == J["value"]
    # the logs' sample time, which an importer may change
    assert float(start["Ts"]) == 0.002


def test_robots_file_is_written_beside_all_values(tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
    file, written = tmp_path / "cart.xml", tmp_path / "found.xml"
    file.write_text(machines.CART)
    paths = machines.cart_runs(tmp_path, machines.heavier(machines.CART), (1, 2))
    words = ["identify", *map(str, paths), "--base", str(file), "--write", str(written)]
    done = RUN.invoke(app, words)
    assert done.exit_code == 0, done.output
    assert "frictionloss=" in written.read_text()
    data = json.loads(written.with_suffix(".json").read_text())
    assert {"o[2]", "wrist.m"} <= {one["name"] for one in data["parameters"]}
    said = f"note: {written} has no place for o[2], o[3]: torques from it alone lack them"
    assert said in done.output
    beside = written.with_suffix(".toml")
    assert f"{beside} has them, too (--base {beside}), and --fmu builds" in done.output
    # which is a base model
    again = RUN.invoke(app, ["identify", *map(str, paths), "--base", str(beside)])
    assert again.exit_code == 0, again.output
    done = RUN.invoke(app, [*words[:-1], str(file)])
    assert "which is read: name another file" in str(done.exception)


def test_out_is_a_folder_as_of_diagnose(runs: list[str], tmp_path: Path) -> None:
    """A file in its place is refused with the option that takes one."""
    words, out = ["identify", *runs[:2], "--base", BASE], tmp_path / "new" / "found"
    done = RUN.invoke(app, [*words, "--held-out", runs[2], "-o", str(out)])
    assert done.exit_code == 0, done.output
    data = json.loads((out / "identified.json").read_text())
    assert data["parameters"]
    page = (out / "identified.html").read_text()
    assert re.search(r"of held-out runs the estimates leave [\d.]+( to [\d.]+)? %", page)
    assert f"{Path(runs[2]).name}, a held-out run: measured" in page
    assert all(one["name"] in page for one in data["parameters"] if one["determined"])
    for more, said in (
        (["--out", str(tmp_path / "a.json")], "must be a folder, as of `diagnose`"),
        (["--out", str(out), "--write", "a.csv"], "names the file already"),
    ):
        refused = RUN.invoke(app, [*words, *more])
        assert getattr(refused.exception, "exit_code", None) == 2, refused.output
        assert said in str(refused.exception)
    assert not (tmp_path / "a.json").exists()


@pytest.mark.parametrize(("base", "file"), [
    ("arm.urdf", "identified.urdf"), ("arm.xml", "identified.xml"), ("arm.sdf", "identified.json"),
    ("axis", "identified.json"), ("hexapod", "identified.toml"),
])  # fmt: skip
def test_out_has_the_file_that_its_base_model_is_written_as(
    base: str, file: str, tmp_path: Path
) -> None:
    assert target(None, tmp_path / "out", base) == tmp_path / "out" / file
    assert (tmp_path / "out").is_dir()


def test_sum_that_is_cut_says_where_it_is_whole(
    runs: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    identified = identify([Path(runs[0])], options=Options(BASE))
    cut = "are cut (--all writes them out)"
    print_identified(identified)
    assert cut not in capsys.readouterr().out
    monkeypatch.setattr("flexhex.identify.other.WIDE", 20)
    print_identified(identified)
    shown = capsys.readouterr().out
    assert cut in " ".join(shown.split())
    print_identified(identified, every=True)
    assert "are cut" not in capsys.readouterr().out


def test_shares_of_all_and_more_are_written_out(runs: list[str]) -> None:
    identified = identify([Path(runs[0])], options=Options(BASE))
    errors = replace(identified.errors, file=np.array([0.0123, 1.001]))
    assert answer(replace(identified, errors=errors)).endswith("the file 1.2 to 100 %.")


def test_doubt_stands_first_and_notes_have_titles(
    runs: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    identified = identify([Path(runs[0])], options=Options(BASE))
    notes = ("coulomb_friction is indistinguishable from load_friction: it is fitted",)
    print_identified(replace(identified, doubt="other signs?", notes=notes))
    shown = capsys.readouterr().out
    assert shown.startswith("Other signs?")
    assert "note: Coulomb friction is indistinguishable from load-dependent friction" in shown

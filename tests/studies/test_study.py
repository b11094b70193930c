"""The study around the scorer, with stand-ins for the diagnosis."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.logs import read_log
from studies import hidden_effects as study
from studies.families import BARE, FAMILIES, Files
from studies.hidden_effects import Task

ENGINE = """
def right(paths, test_paths, machine_file):
    return {"verdict": "none", "effects": [], "changed": [], "shown": {"large": 1}}

def faulty(paths, test_paths, machine_file):
    raise RuntimeError("no idea")

def sure(paths, test_paths, machine_file):
    row = {"before": 3.0, "after": 1.0, "non_repeatable": 0.9}
    residual = {"judged_on": "held-out runs", "per_axis": {"1": row}}
    effects = [{"id": "offset_drift", "axes": [1]}]
    return {"verdict": "named", "effects": effects, "changed": [], "residual": residual}

def curious(paths, test_paths, machine_file):
    near = sorted({p.suffix for path in paths for p in path.parent.rglob("*")})
    return {"verdict": "none", "effects": [], "changed": [], "notes": [*near, len(test_paths)]}
"""


@pytest.fixture
def toy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A store beside toy engines, and short runs."""
    (tmp_path / "toy_engine.py").write_text(ENGINE)
    monkeypatch.setenv("PYTHONPATH", f"{Path.cwd()}:{tmp_path}")
    monkeypatch.setattr("studies.mujoco.draw.MOST_STEPS", 3000)
    return tmp_path / "store.jsonl"


def test_a_study_goes_on_where_it_stopped(toy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    common = ["--mujoco", "8:9", "--store", str(toy), "--category", "nothing"]
    assert study.main([*common, "--engine", "toy_engine:right"]) == 0
    first = toy.read_text()
    with toy.open("a") as file:
        file.write('{"seed": 9, "outc')
    assert study.main([*common, "--engine", "toy_engine:right"]) == 0
    assert toy.read_text() == first
    assert "| nothing hidden | silent |" in capsys.readouterr().out
    (row,) = study.read(toy)
    assert row["answer"] == {"verdict": "none", "effects": [], "changed": []}
    assert row["peak_bytes"] > 1e6
    assert study.main([*common, "--engine", "toy_engine:faulty"]) == 1
    assert study.read(toy)[1]["outcome"]["outcome"] == "failed"
    assert "no idea" in study.read(toy)[1]["error"]


def test_stored_answers_are_judged_by_the_scorer_of_today(toy: Path) -> None:
    row = study.case(Task("mujoco", 8, "nothing", "toy_engine:right"))
    assert study.outcome_of(row).outcome == "silent"
    row["answer"]["effects"] = [{"id": "drag", "axes": [1]}]
    assert study.outcome_of(row).outcome == "false_alarm"
    failed = study.case(Task("mujoco", 8, "nothing", "toy_engine:faulty"))
    assert study.outcome_of(failed).outcome == "failed"


def test_a_study_prints_json_for_the_results(toy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    common = ["--store", str(toy), "--category", "nothing", "--engine", "toy_engine:right"]
    assert study.main(["--mujoco", "8:9", *common, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    (case,) = data["cases"]
    assert (case["seed"], case["outcome"], case["named_axes"]) == (8, "silent", [])
    (silent,) = (c for c in data["families"]["mujoco"] if c["ending"] == "silent")
    assert (silent["hits"], silent["n"]) == (1, 1)


@pytest.mark.parametrize("family", ["generator", "axes"])
def test_an_engine_sees_no_truth(family: str, toy: Path) -> None:
    row = study.case(Task(family, 2, engine="toy_engine:curious"))
    assert row["answer"]["notes"] in ([".h5", 2], [".h5", ".toml", 2])
    assert row["outcome"]["family"] == family


def test_a_store_of_another_study_and_test_seeds_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store = tmp_path / "store.jsonl"
    store.write_text(json.dumps({"task": ["seed", 1]}) + "\n")
    with pytest.raises(ValueError, match=":1: no case of this study"):
        study.read(store)
    for family in FAMILIES:
        with pytest.raises(SystemExit):
            study.main([f"--{family}", "9999:10001", "--store", str(tmp_path / "new.jsonl")])
        assert "seed 10000: from 10000 on for tests only, say --test" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        study.main(["--mujoco", "1", "--store", str(store)])
    assert "no case of this study" in capsys.readouterr().err


def test_a_case_that_cannot_be_made_is_reported_and_the_study_goes_on(
    toy: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    common = ["--category", "nothing", "--engine", "toy_engine:right", "--store", str(toy)]
    assert study.main(["--axes", "1", "--mujoco", "8", *common]) == 1
    shown = capsys.readouterr()
    assert "axes 1: FAILED" in shown.err
    assert "draws its own" in shown.err
    assert "| nothing hidden | silent |  | 1 of 1" in shown.out


def both(family: str, seed: int, folder: Path) -> dict[str, Files]:
    """A case, and the same machine with nothing hidden."""
    makers = {"whole": FAMILIES[family], "bare": BARE[family]}
    return {k: f(seed, folder / k, folder / f"truth-{k}", None) for k, f in makers.items()}


def test_bare_machine_of_mujoco_is_the_same_but_for_what_is_hidden(tmp_path: Path) -> None:
    made = both("mujoco", 4, tmp_path)
    whole, bare = (json.loads(files.sealed.read_text()) for files in made.values())
    assert [h["id"] for h in whole["hidden"]] == ["torque_constant_saturation"]
    assert (bare["hidden"], bare["category"]) == ([], "nothing")
    assert len({files.machine_file.read_text() for files in made.values()}) == 1
    # the motion for tests is too slow to saturate: there motion and noise are the same to a bit
    slow, other = (read_log(files.test_paths[0])["tau_meas"].values for files in made.values())
    assert np.array_equal(slow, other)
    fast, other = (read_log(files.paths[0])["tau_meas"].values for files in made.values())
    assert not np.array_equal(fast, other)


def test_bare_machine_of_the_generator_differs_by_the_effect(tmp_path: Path) -> None:
    made = both("generator", 0, tmp_path)
    (hidden,) = json.loads(made["whole"].sealed.read_text())["hidden"]
    assert json.loads(made["bare"].sealed.read_text())["hidden"] == []
    whole, bare = (read_log(files.paths[0])["tau_meas"].values for files in made.values())
    axis = hidden["axes"][0] - 1
    apart = np.linalg.norm(whole - bare, axis=0) / np.linalg.norm(bare, axis=0)
    assert 0.5 * hidden["size"] < apart[axis] < 2 * hidden["size"]
    assert np.delete(apart, axis).max() < 0.1 * apart[axis]


def test_twin_of_a_right_answer_is_stored_and_judged(toy: Path) -> None:
    row = study.case(Task("mujoco", 0, "single", "toy_engine:sure"))
    assert row["outcome"]["outcome"] == "right"
    # the stand-in says of any runs that 3 became 1: nothing was added, so nothing was removed
    assert row["twin"] == row["answer"]["residual"]
    assert row["outcome"]["closed"] is None
    row["twin"]["per_axis"]["1"]["before"] = 1.5
    assert study.outcome_of(row).closed == pytest.approx((3.0 - 1.0) / (3.0 - 1.5))
    assert study.outcome_of(row | {"twin": None}).closed is None

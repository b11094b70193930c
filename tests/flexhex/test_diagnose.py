"""The command `diagnose`: exit codes, who is asked, what stands on stdout."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import flexhex.diagnose.command as command
import flexhex.diagnose.options as options
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.fmus.common.errors import LogError, UsageError
from tests.flexhex.conftest import ADDED, Workflow
from tests.flexhex.diagnoses import AMBIGUOUS, CANNOT, EXAMPLES, NONE, UNKNOWN


@pytest.mark.parametrize("name", EXAMPLES)
def test_exit_code_is_0_only_without_residual_or_with_what_was_added(
    name: str, workflow: Workflow, call: Callable[..., Any], tmp_path: Path
) -> None:
    workflow.answer = EXAMPLES[name]
    done = call("run1.csv")
    good = EXAMPLES[name].verdict == "none" or EXAMPLES[name].machine is not None
    assert done.exit_code == (0 if good else 1), done.output
    assert (tmp_path / "diagnosis.html").is_file()
    kept = json.loads((tmp_path / "diagnosis.json").read_text())
    assert kept["verdict"] == EXAMPLES[name].verdict


def test_apply_adds_without_asking(workflow: Workflow, call: Callable[..., Any]) -> None:
    done = call("run1.csv", "--apply")
    assert (done.exit_code, workflow.added) == (0, True)
    assert "copy of the machine file and build it?" not in done.output


@pytest.mark.parametrize("diagnosis", [NONE, UNKNOWN, CANNOT], ids=lambda f: f.verdict)
def test_apply_adds_nothing_where_nothing_was_named(
    diagnosis: Diagnosis, workflow: Workflow, call: Callable[..., Any]
) -> None:
    workflow.answer = diagnosis
    call("run1.csv", "--apply")
    assert workflow.added is False


@pytest.mark.parametrize("more", [[], ["--json"]])
def test_nobody_is_asked_without_terminal_or_with_json(
    more: list[str],
    workflow: Workflow,
    call: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(command, "interactive", lambda: bool(more))
    done = call("run1.csv", *more, answer="y\n")
    assert (done.exit_code, workflow.added) == (1, False)
    assert "build it?" not in done.output


@pytest.mark.parametrize(("answer", "code"), [("y\n", 0), ("n\n", 1), ("\n", 1)])
def test_in_a_terminal_the_user_decides(
    answer: str,
    code: int,
    workflow: Workflow,
    call: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(command, "interactive", lambda: True)
    done = call("run1.csv", answer=answer)
    assert (done.exit_code, workflow.added) == (code, code == 0)
    question = "Add Coulomb friction on axis 3 to a copy of the machine file and build it?"
    assert question in done.stderr
    assert done.stdout.count("Axis 3 has Coulomb friction") == 1, "said once, before the question"
    assert (f"machine  {ADDED}" in done.stdout) is (code == 0)


def test_question_says_that_rivals_are_as_good(
    workflow: Workflow, call: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    workflow.answer = AMBIGUOUS
    monkeypatch.setattr(command, "interactive", lambda: True)
    assert "(the best of 3 indistinguishable effects)" in call("run1.csv", answer="n\n").stderr


@pytest.mark.parametrize("name", EXAMPLES)
def test_json_is_all_that_stands_on_stdout(
    name: str, workflow: Workflow, call: Callable[..., Any]
) -> None:
    workflow.answer = EXAMPLES[name]
    done = call("run1.csv", "--json")
    data = json.loads(done.stdout, parse_constant=lambda text: pytest.fail(f"{text} in JSON"))
    assert data["verdict"] == EXAMPLES[name].verdict
    assert [e["id"] for e in data["effects"]] == [e.id for e in EXAMPLES[name].effects]
    assert data["residual"]["unit"] == "N m"
    assert Path(data["report"]).is_file()
    assert "diagnosing" in done.stderr


def test_held_out_takes_all_words_to_the_next_option(
    workflow: Workflow, call: Callable[..., Any]
) -> None:
    call("a.csv", "b.csv", "--held-out", "c.csv", "d.csv", "--base", "axis", "--locked", "e.csv")
    assert [p.name for p in workflow.seen["paths"]] == ["a.csv", "b.csv"]
    assert [p.name for p in workflow.seen["held_out"]] == ["c.csv", "d.csv", "e.csv"]
    assert workflow.seen["options"].base == "axis"


@pytest.mark.parametrize(
    ("words", "taken"), [("c.csv a.csv b.csv", "all 3 files"), ("c.csv --json", "the only file")]
)
def test_held_out_that_took_the_runs_is_named(
    words: str, taken: str, call: Callable[..., Any]
) -> None:
    done = call("--base", "axis", "--held-out", *words.split())
    assert isinstance(done.exception, UsageError)
    assert str(done.exception).startswith(f"--held-out took {taken}, as it takes all words up to")
    assert "put the runs that are fitted before it" in str(done.exception)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--locked", "a", "b"], ["--locked", "a", "--locked", "b"]),
        (["--locked=a", "b"], ["--locked=a", "b"]),
        (["r", "--locked", "a", "--json"], ["r", "--locked", "a", "--json"]),
        (["--", "--locked", "a", "b"], ["--", "--locked", "a", "b"]),
    ],
)
def test_greedy_words_are_repeated(words: list[str], expected: list[str]) -> None:
    assert options.repeated(words) == expected


def test_base_decides_on_the_machine_file(workflow: Workflow, call: Callable[..., Any]) -> None:
    call("a.csv")
    assert workflow.seen["machine"].name == "tflex.toml"
    call("a.csv", "--base", "axis")
    assert workflow.seen["machine"] is None


def test_options_of_logs_arrive(workflow: Workflow, call: Callable[..., Any]) -> None:
    call("a.csv", "--torque-constant", "3.0,3.1", "--unit", "theta=deg", "--rename", "q=1=theta")
    logs = workflow.seen["options"].log
    assert logs.torque_constant == (3.0, 3.1)
    assert (logs.units, logs.rename) == ({"theta": "deg"}, {"q=1": "theta"})
    call("a.csv", "--torque-constant", "3.0")
    assert workflow.seen["options"].log.torque_constant == 3.0


def test_tolerances_arrive(workflow: Workflow, call: Callable[..., Any]) -> None:
    call("a.csv", "--tolerance", "mass=0.1", "--tolerance", "geometry=0")
    assert workflow.seen["options"].tolerance == {"mass": 0.1, "geometry": 0.0}


def test_effect_with_rivals_gets_its_experiment_written(
    workflow: Workflow,
    call: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    seen: list[Any] = []

    def planned(diagnosis: Diagnosis, *more: Any) -> Diagnosis:
        seen.extend(more)
        return diagnosis

    monkeypatch.setattr("flexhex.diagnosis.planning.experiment.with_experiments", planned)
    call("a.csv")
    assert seen == [], "no rivals, no experiment"
    workflow.answer = AMBIGUOUS
    call("a.csv")
    limits, folder, ts = seen
    assert (limits.high[0], folder, ts) == (pytest.approx(0.5236, abs=1e-4), tmp_path, 0.25e-3)
    path = tmp_path / "a.csv"
    rows = "\n".join(f"{0.002 * k:.3f},{0.01 * (k % 30)},{k % 7}" for k in range(300))
    path.write_text(f"time,theta[1],tau_meas[1]\ns,rad,N m\n{rows}\n")
    call(str(path), "--base", "axis")
    assert (seen[3].high[0], seen[5]) == (pytest.approx(0.29), pytest.approx(0.002))


MISTAKES = {
    "nothing to add to": (["a.csv", "--base", "axis", "--apply"], "has no machine file to add"),
    "machine file of an arm": (
        ["a.csv", "--base", "axis", "--machine", "arm.urdf"],
        r"--machine arm\.urdf: --base axis reads no machine file",
    ),
    "base": (["a.csv", "--base", "robot"], "there are hexapod, axis, a"),
    "run and held out": (
        ["a.csv", "--held-out", "./a.csv"],
        r"a\.csv is given as a run to fit and as",
    ),
    "constant": (["a.csv", "--torque-constant", "strong"], "write a number, or one for each axis"),
    "zero": (["a.csv", "--torque-constant", "0"], "must be a number other than zero"),
    "endless": (["a.csv", "--torque-constant", "inf"], "must be a number other than zero"),
    "not a number": (["a.csv", "--torque-constant", "nan"], "must be a number other than zero"),
    "unit": (["a.csv", "--unit", "deg"], "--unit deg: write NAME=VALUE"),
    "tolerance of what": (
        ["a.csv", "--tolerance", "masss=0.1"],
        "tolerance 'masss': there are mass,",
    ),
    "tolerance in per cent": (
        ["a.csv", "--tolerance", "mass=5"],
        "tolerance mass = 5.0, must be at",
    ),
    "no tolerance": (["a.csv", "--tolerance", "mass"], "--tolerance mass: write KEY=NUMBER"),
    "tolerance without a file": (
        ["a.csv", "--base", "axis", "--tolerance", "mass=0.1"],
        "--tolerance: --base axis reads no machine file",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_wrong_option_is_a_usage_error(
    mistake: str, workflow: Workflow, call: Callable[..., Any]
) -> None:
    words, message = MISTAKES[mistake]
    error = call(*words).exception
    assert isinstance(error, UsageError), error
    with pytest.raises(UsageError, match=message):
        raise error
    assert workflow.seen == {}, "nothing was started"


def test_bad_input_says_nothing_on_stdout(workflow: Workflow, call: Callable[..., Any]) -> None:
    workflow.answer = LogError("a.csv: no such file")
    done = call("a.csv", "--json")
    assert isinstance(done.exception, LogError)
    assert (done.exception.exit_code, done.stdout) == (3, "")

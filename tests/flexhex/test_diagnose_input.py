"""`flexhex diagnose` as a whole with what users give it: one clear message, an exit code, never a
traceback. The logs are of one axis, so that it is quick."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from flexhex import cli
from tests.diagnosis.single import write
from tests.diagnosis.synthetic import motion, plain_csv

HEAD = ["# trajectory: 1", "# pass: 1", "time,theta[1],tau_meas[1]", "s,rad,N m"]


@dataclass(frozen=True)
class Done:
    code: int
    out: str
    err: str


@dataclass(frozen=True)
class User:
    """Calls the command in a folder of its own; `good`: two motions, two passes each."""

    folder: Path
    good: list[Path]
    call: Callable[..., Done]

    def rows(self) -> list[list[str]]:
        lines = self.good[0].read_text().splitlines()[len(HEAD) :]
        return [line.split(",") for line in lines]

    def file(self, name: str, rows: list[list[str]], head: list[str] | None = None) -> Path:
        path = self.folder / name
        lines = [*(HEAD if head is None else head), *(",".join(row) for row in rows)]
        path.write_text("\n".join([*lines, ""]))
        return path


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("runs")
    return [write(folder / f"{s}_{k}.csv", s, k, 0.12) for s in (1, 2) for k in (1, 2)]


@pytest.fixture
def user(
    runs: list[Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> User:
    def call(*words: object, base: str = "axis", out: Path | None = None) -> Done:
        given = [
            "diagnose",
            *map(str, words),
            "--base",
            base,
            "--out",
            str(out or tmp_path / "out"),
        ]
        monkeypatch.setattr(sys, "argv", ["flexhex", *given])
        code = 0
        try:
            cli.main()
        except SystemExit as end:
            code = int(end.code or 0)
        said = capsys.readouterr()
        return Done(code, said.out, said.err)

    return User(tmp_path, runs, call)


def shown(text: str) -> str:
    """Lines of a terminal as one."""
    return " ".join(text.split())


def test_two_motions_and_a_held_out_one_end_with_a_name_and_a_page(user: User) -> None:
    held_out = write(user.folder / "held-out.csv", 3, 1, 0.12)
    done = user.call(*user.good, "--held-out", held_out, "--json")
    data = json.loads(done.out)
    # the axis has a little more friction when slow, which these runs hardly show
    assert done.code == 1
    assert data["verdict"] in ("named", "ambiguous")
    assert [effect["id"] for effect in data["effects"]] == ["coulomb_friction"]
    assert set(data["effects"][0]["rivals"]) <= {"stribeck_friction"}
    assert data["residual"]["judged_on"] == "held-out runs"
    assert Path(data["report"]).read_text().count("Coulomb friction") > 1


def test_isolability_of_one_axis_ends_with_a_table_and_a_page(user: User) -> None:
    done = user.call(user.good[0], "--isolability", "--json")
    data = json.loads(done.out)
    assert done.code == 0
    assert "coulomb_friction" in data["effects"]
    assert Path(data["report"]).is_file()


FILES: dict[str, tuple[Callable[[User], Path], str]] = {
    "empty": (lambda u: u.file("a.csv", [], []), "an empty file"),
    "header alone": (lambda u: u.file("a.csv", []), "no samples"),
    "one row": (lambda u: u.file("a.csv", u.rows()[:1]), "1 samples are too few"),
    "twenty rows": (lambda u: u.file("a.csv", u.rows()[:20]), "at least 0.312 s are needed"),
    "all NaN": (
        lambda u: u.file("a.csv", [[r[0], "nan", "nan"] for r in u.rows()]),
        "no sample in which all axes are numbers",
    ),
    "no units": (lambda u: u.file("a.csv", u.rows(), HEAD[:3]), "--unit time=s"),
    "an angle without unit": (
        lambda u: u.file("a.csv", u.rows(), [*HEAD[:3], "s,,N m"]),
        "theta has no unit, wanted 'rad'",
    ),
    "backwards": (lambda u: u.file("a.csv", u.rows()[::-1]), "time runs backwards 11999 times"),
    "nanoseconds": (
        lambda u: u.file("a.csv", [[f"{k}e-9", *r[1:]] for k, r in enumerate(u.rows()[1:])]),
        "is `time` in seconds?",
    ),
    "no torque": (
        lambda u: u.file("a.csv", [r[:2] for r in u.rows()], ["time,theta[1]", "s,rad"]),
        "no channels tau_meas[1]",
    ),
    "folder": (lambda u: u.folder, "is a folder: name a file in it"),
    "missing": (lambda u: u.folder / "none.csv", "no such file"),
    "another number of axes": (
        lambda u: plain_csv(u.folder / "a.csv", motion(4.0)),
        "theta has 2 axes, the model has 1",
    ),
}


@pytest.mark.parametrize("name", FILES)
def test_file_that_cannot_be_used_is_one_message(name: str, user: User) -> None:
    content, message = FILES[name]
    path = content(user)
    done = user.call(user.good[0], path)
    assert done.code == 3, done
    said = done.err.strip().splitlines()[-1]
    assert said.startswith("flexhex: "), "one line, no traceback"
    assert path.name in said
    assert message in said
    assert done.out == ""


@pytest.mark.parametrize("option", [[], ["--held-out"]])
def test_copy_of_a_run_is_no_second_pass(option: list[str], user: User) -> None:
    """Its noise repeats to the last digit and would be named as an effect."""
    copy = user.folder / "copy.csv"
    copy.write_text(user.good[0].read_text().replace("pass: 1", "pass: 2"))
    done = user.call(user.good[0], *option, copy)
    assert done.code == 3
    assert f"{copy}: the same samples as {user.good[0]}" in done.err


OPTIONS: dict[str, tuple[list[str], str]] = {
    "twice": (["RUN"], "is given twice: name each run once"),
    "run and held out": (["--held-out", "RUN"], "is given as a run to fit and as a held-out run"),
    "unit of nothing": (["--unit", "angle=deg"], "no channel of that name; there are time, theta"),
    "unit of an axis": (["--unit", "theta[1]=deg"], "write theta=deg, for all its axes"),
    "unit half": (["--unit", "theta="], "write NAME=VALUE"),
    "channel of nothing": (["--rename", "q=angle"], "no such channel; there are time, theta"),
    "report": (["--report", "FOLDER"], "cannot be written (it is a folder"),
    "isolability of runs": (["--isolability", "--held-out", "b.csv"], "before any run"),
    "isolability added": (["--isolability", "--base", "hexapod", "--apply"], "before any run"),
}


@pytest.mark.parametrize("name", OPTIONS)
def test_wrong_option_is_one_message(name: str, user: User) -> None:
    words, message = OPTIONS[name]
    places = {"RUN": str(user.good[0]), "FOLDER": str(user.folder)}
    given = [places.get(word, word) for word in words]
    done = user.call(*user.good, *given, base="hexapod" if "--apply" in given else "axis")
    assert done.code == (3 if name == "report" else 2), done
    assert message in done.err
    assert "Traceback" not in done.err


def test_folder_that_cannot_be_written_is_reported_before_any_work(user: User) -> None:
    (user.folder / "file").write_text("")
    for out in (user.folder / "file", user.folder / "file" / "sub"):
        done = user.call(*user.good, out=out)
        assert done.code == 3
        assert f"--out {out}: cannot be written" in done.err
        assert "fitting" not in done.err


def test_machine_file_that_is_missing_is_named(user: User) -> None:
    done = user.call(*user.good, "--machine", user.folder / "none.toml", base="hexapod")
    assert done.code == 3
    assert "none.toml: no such file" in done.err


def test_other_machine_is_refused(user: User) -> None:
    done = user.call(*user.good, base="hexapod")
    assert (done.code, "theta has 1 axis, the model has 6: add --base" in done.err) == (3, True)


@pytest.mark.parametrize("isolability", [True, False])
def test_trajectories_of_other_axes_are_refused(isolability: bool, user: User) -> None:
    two = plain_csv(user.folder / "two.csv", motion(4.0))
    done = user.call(user.good[0], two, *(["--isolability"] if isolability else []))
    assert (done.code, "2 axes, the model has 1" in done.err) == (3, True)


def test_run_in_another_unit_is_doubted(user: User) -> None:
    rows = [[r[0], r[1], str(1e3 * float(r[2]))] for r in user.rows()]
    done = user.call(user.file("a.csv", rows), user.good[1])
    assert done.code == 1
    assert "do not decide" in shown(done.out)
    assert "of the same motion: another unit?" in shown(done.out)


def test_run_that_stands_still_cannot_tell(user: User) -> None:
    rows = [[r[0], "0.1", r[2]] for r in user.rows()]
    done = user.call(user.file("a.csv", rows))
    assert done.code == 1
    assert "a run must excite the machine" in shown(done.out)


def test_numbers_that_are_missing_change_no_name(user: User) -> None:
    rows = [[r[0], "nan", "nan"] if 3000 < k < 5000 else r for k, r in enumerate(user.rows())]
    done = user.call(user.file("a.csv", rows), *user.good[1:])
    assert "Coulomb friction" in shown(done.out)
    assert "is not a number in 1999 samples" in shown(done.out)


def test_torque_constant_that_is_not_used_is_reported(user: User) -> None:
    done = user.call(user.good[0], "--torque-constant", "3.0")
    assert "the torque constant that was given is not used" in shown(done.out)


def test_units_of_a_planned_motion_can_be_given(user: User) -> None:
    degrees = [[r[0], str(np.degrees(float(r[1]))), r[2]] for r in user.rows()]
    plain, with_units = user.good[0], user.file("a.csv", degrees, [*HEAD[:3], "s,,N m"])
    a = json.loads(user.call(plain, "--isolability", "--json").out)
    b = json.loads(user.call(with_units, "--isolability", "--json", "--unit", "theta=deg").out)
    first, second = (np.array(values["smallest"]["values"], dtype=float) for values in (a, b))
    # angles of seven digits
    np.testing.assert_allclose(first, second, rtol=1e-3)

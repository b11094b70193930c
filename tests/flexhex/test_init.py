"""`flexhex init`: the example is written once, into a Python file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.logs import Log
from flexhex.fmus.common.errors import MachineError, OutputError, UsageError
from flexhex.fmus.common.machine_file import load_machine
from flexhex.init.command import EXAMPLES, Kind
from tests.conftest import MACHINE_FILE
from tests.diagnosis.robots import walled


def test_init_writes_the_example_and_says_how_to_use_it(tmp_path: Path) -> None:
    file = tmp_path / "base.py"
    done = CliRunner().invoke(app, ["init", str(file)])
    assert done.exit_code == 0
    assert file.read_text() == EXAMPLES[Kind.base][0].read_text()
    assert f"--base {file}:TwoLinks" in done.output


def test_init_writes_an_effect_where_the_name_or_the_option_says_so(tmp_path: Path) -> None:
    for words in (["my_effect.py"], ["other.py", "--kind", "effect"]):
        file = tmp_path / words[0]
        done = CliRunner().invoke(app, ["init", str(file), *words[1:]])
        assert file.read_text() == EXAMPLES[Kind.effect][0].read_text()
        assert f"--effect {file}:GasSpring" in done.output


def test_init_writes_what_a_robots_file_cannot_say(tmp_path: Path) -> None:
    """As it is, and with all that is commented out in it."""
    pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
    file = tmp_path / "my_robot.toml"
    done = CliRunner().invoke(app, ["init", str(file)])
    assert f"--base {file}" in done.output
    (tmp_path / "robot.urdf").write_text(walled.URDF)
    assert base_of(str(file), None, Log.of("a", 0.01, *np.zeros((2, 9, 3)))).n == 3
    lines = [line.removeprefix("# ") for line in file.read_text().splitlines()[3:]]
    file.write_text("\n".join(lines))
    base = base_of(str(file), None, Log.of("a", 0.01, *np.zeros((2, 9, 2))))
    assert base.linear[-2].nominal == pytest.approx(1.2e-5 * 101**2)


@pytest.mark.parametrize(("name", "kind"), [("a.py", "robot"), ("a.toml", "base")])
def test_init_refuses_a_kind_of_another_ending(name: str, kind: str, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["init", str(tmp_path / name), "--kind", kind])
    assert isinstance(done.exception, UsageError)
    assert not (tmp_path / name).exists()


def test_init_replaces_nothing(tmp_path: Path) -> None:
    file = tmp_path / "base.py"
    file.write_text("mine")
    done = CliRunner().invoke(app, ["init", str(file)])
    assert isinstance(done.exception, OutputError)
    assert file.read_text() == "mine"


@pytest.mark.parametrize(
    ("name", "error"), [("base.txt", UsageError), ("none/base.py", OutputError)]
)
def test_init_refuses_other_files(name: str, error: type[Exception], tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["init", str(tmp_path / name)])
    assert isinstance(done.exception, error)


def test_machine_of_the_usual_lengths_is_the_t_flex(tmp_path: Path) -> None:
    """Without options the geometry is that of machines/tflex.toml, which it does not read."""
    file = tmp_path / "my.toml"
    done = CliRunner().invoke(app, ["init", str(file)])
    assert done.exit_code == 0, done.output
    ours, theirs = load_machine(file), load_machine(MACHINE_FILE)
    assert ours.name == "my"
    assert ours.platform.l == pytest.approx(theirs.platform.l, abs=1e-9)
    for mine, arm in zip(ours.arms, theirs.arms, strict=True):
        for name in ("x_B", "axis", "u_B", "r_EP"):
            assert np.allclose(getattr(mine, name), getattr(arm, name), atol=1e-9), name
    page = file.with_suffix(".html").read_text(encoding="utf-8")
    assert "each joint in turn" in page


@pytest.mark.parametrize("upper", [0.1, 0.4])
def test_all_arms_of_any_lengths_close(upper: float, tmp_path: Path) -> None:
    """The distance from the end of each upper arm to its joint on the platform is l."""
    file = tmp_path / "my.toml"
    lengths = ["--radius", "0.1", "--height", "0.25", "--upper", str(upper), "--lift", "0.5"]
    assert CliRunner().invoke(app, ["init", str(file), *lengths]).exit_code == 0
    machine = load_machine(file)
    for arm in machine.arms:
        assert arm.r_EP is not None
        knee = np.array(arm.x_B) + upper * np.array(arm.u_B)
        joint = np.array([0.0, 0.0, 0.25]) + np.array(arm.r_EP)
        assert np.linalg.norm(joint - knee) == pytest.approx(machine.platform.l, abs=1e-8)
    assert machine.bodies.upper.c[0] == pytest.approx(0.13 * upper / 0.28)


def test_machine_that_holds_no_motion_is_refused(tmp_path: Path) -> None:
    """Lower arms that hang straight down, side by side: the platform swings."""
    file = tmp_path / "my.toml"
    lengths = ["--radius", "0.2", "--upper", "0.1", "--lift", "0"]
    side = str(0.6 * np.tan(np.pi / 6))  # of a regular hexagon, above and below
    lengths += ["--spacing", side, "--platform-radius", "0.3", "--platform-spacing", side]
    done = CliRunner().invoke(app, ["init", str(file), *lengths])
    assert isinstance(done.exception, MachineError), done.output
    assert list(tmp_path.iterdir()) == []

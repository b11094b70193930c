"""`flexhex check` and every build refuse what a later stage would: with file and field."""

from __future__ import annotations

import re
from functools import reduce
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flexhex.check.files import check_file
from flexhex.cli import app
from flexhex.fmugen.blocks import BLOCKS, block_interface
from flexhex.fmus.common.errors import MachineError, StartValueError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.run.actuators import actuators_builder
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import whole_moves
from flexhex.simulation.fields import keys_of, shown
from tests.common.test_machine_file import Edit, replace
from tests.conftest import MACHINE_FILE

TRUTH = MACHINE_FILE.with_name("tflex-truth.toml")


def chain(*edits: Edit) -> Edit:
    """All edits, one after the other."""
    return lambda text: reduce(lambda done, edit: edit(done), edits, text)


CASES: dict[str, tuple[Edit, str]] = {
    "amplitude beyond the stroke": (
        replace("amplitude = { value = 0.233", "amplitude = { value = 0.6"),
        r"reference\.amplitude is 0\.6 rad, must be within geometry\.stroke, 0\.523599 rad",
    ),
    "duration not whole": (
        replace("duration = { value = 50.0", "duration = { value = 50.3"),
        r"reference: duration is 50\.3 times period, must be a whole number: 50 s would be",
    ),
    "move longer than period": (
        replace("period = { value = 1.0", "period = { value = 0.5"),
        r"reference: move is 0\.6 s, longer than period, 0\.5 s",
    ),
    "period between base steps": (
        replace("period = { value = 1.0", "period = { value = 0.7142857142857143"),
        r"reference\.period is 2857\.14286 base steps, must be a whole number",
    ),
    "hold between base steps": (
        chain(
            replace("base = { value = 0.00025", "base = { value = 0.0003"),
            replace("feedforward = { value = 0.0005", "feedforward = { value = 0.0006"),
            replace("period = { value = 1.0", "period = { value = 0.9"),
            replace("duration = { value = 50.0", "duration = { value = 45.0"),
        ),
        r"timing\.base: the 2 s held before the first move are 6666\.66667 base steps",
    ),
    "crossover": (
        replace("f_crossover = { value = 10.0", "f_crossover = { value = 400.0"),
        r"control\.phase_margin = 0\.7854 rad at 400 Hz needs a lead of .*: change the margin",
    ),
    "margin": (
        replace("phase_margin = { value = 0.785", "phase_margin = { value = 1.485"),
        r"control\.phase_margin = 1\.485 rad at 10 Hz needs a lead",
    ),
    "slow feedforward": (
        replace("feedforward = { value = 0.0005", "feedforward = { value = 0.0075"),
        r"timing\.feedforward = 0\.0075 s, .*: reference_delay is 76\.6\d+, must be 0 to 64 ",
    ),
    "sample times that do not meet": (
        replace("feedforward = { value = 0.0005", "feedforward = { value = 0.00175"),
        r"timing: path W -> N_E -> K: the age of a sample varies .* divide one another",
    ),
    "adaptation": (
        replace("adaptation = { value = 0.03", "adaptation = { value = 30.0"),
        r"timing\.adaptation = 30 s: must be 1e-06 to 10 s \(range of Ts in estimator\.fmu\)",
    ),
    "encoder step": (
        replace("step = { value = 1e-08", "step = { value = 1.0"),
        r"encoder\.step = 1 rad: must be 0 to 0\.1 rad \(range of theta_step in plant\.fmu\)",
    ),
    "current": (
        replace("I_peak = { value = 9.0", "I_peak = { value = 9e9"),
        r"drive\.K_t = 3 N m/A, drive\.I_peak = 9e\+09 A: tau_max is 2\.7e\+10 N m, .* of them$",
    ),
    "cogging": (
        replace("[0.01537, 0.0186", "[1537.0, 0.0186"),
        r"actuator\.a\[1,1\] = 1537 N m: must be -100 to 100 N m \(range of actuator\[1\]"
        r"\.a\[1\] in plant",
    ),
    "mass in grams": (
        replace("m = { value = 1.25,", "m = { value = 1250.0,"),
        r"bodies\.end_effector\.m = 1250 kg: must be 0 to 100 kg .* meant in another unit\?$",
    ),
    "first moment": (
        replace('m = { value = 0.5, unit = "kg"', 'm = { value = 2200.0, unit = "kg"'),
        r"bodies\.upper\.m = 2200 kg, bodies\.upper\.c = \[0\.13, 0, -0\.004\] m: "
        r"mechanism\.upper\[1\]\.mc_x is 286 kg m, must be -100 to 100 kg m",
    ),
    "hysteresis too sharp for the plant's step": (
        replace("sigma = { value = 0.015", "sigma = { value = 1e-9"),
        r"actuator\.sigma is 1e-09 rad, at least 0\.000279 rad are needed",
    ),
    "whole number with a point": (
        replace("hann_points = 101", "hann_points = 101.0"),
        r"control\.hann_points: wants a whole number without point or quotes, is 101\.0",
    ),
    "whole number in quotes": (
        replace("n_harmonics = 9", 'n_harmonics = "9"'),
        r"actuator\.n_harmonics: wants a whole number without point or quotes, is '9'",
    ),
}

SET_BY_NO_FILE = {
    *("kind", "seed", "t_start", "passes", "speed", "rounding", "fade", "f_base", "n_sines"),
    *("f0", "f1", "payload_count", "payload_time", "payload_mass", "corrections", "tolerance"),
    *("basis", "play", "substeps", "ff_gain", "e_max", "adapt", "margin"),
}
"""Parameters whose start values are the same for all machines."""


def written(folder: Path, edit: Edit) -> Path:
    """A machine file of its own, edited."""
    path = folder / "mine.toml"
    path.write_text(edit(MACHINE_FILE.read_text(encoding="utf-8")), encoding="utf-8")
    return path


@pytest.mark.parametrize("case", CASES)
def test_check_refuses_what_no_block_takes(case: str, tmp_path: Path) -> None:
    edit, message = CASES[case]
    path = written(tmp_path, edit)
    complaints = check_file(path)
    assert len(complaints) == 1, complaints
    assert complaints[0].startswith(f"{path}: ")
    assert complaints[0].count(str(path)) == 1
    assert re.search(message, complaints[0]), complaints[0]
    with pytest.raises(MachineError, match=message):
        Builder(path, tmp_path / "out").fmus()
    assert not (tmp_path / "out").exists(), "nothing is compiled before"


def test_every_start_value_of_a_machine_has_its_keys(machine: Machine) -> None:
    """All parameters but those that no machine file sets; each of the keys is in the file."""
    without = set()
    for block in BLOCKS:
        for variable in block_interface(block, machine).parameters:
            for name in variable.scalar_names:
                error = StartValueError(name, 0.0, (1.0, 2.0), variable.unit)
                keys = keys_of(error, block)
                assert all(" = " in shown(machine, key) for key in keys)
                if not keys:
                    without.add(variable.name)
    assert without <= SET_BY_NO_FILE, without - SET_BY_NO_FILE


@pytest.mark.parametrize("name", ["tflex.toml", "tflex-actuators.toml", "tflex-truth.toml"])
def test_check_accepts_the_shipped_files(name: str) -> None:
    assert check_file(MACHINE_FILE.with_name(name)) == []


@pytest.mark.parametrize(
    ("g", "warned"), [("0.0, 0.0, 9.81", True), ("0.0, 0.0, -9.81", False), ("9.81, 0, 0", False)]
)
def test_check_warns_of_gravity_that_points_upward(g: str, warned: bool, tmp_path: Path) -> None:
    """A machine may hang, so the file is good; a wrong sign is not silent."""
    path = written(tmp_path, replace("g = { value = [0.0, 0.0, -9.81]", f"g = {{ value = [{g}]"))
    done = CliRunner().invoke(app, ["check", str(path)])
    assert done.exit_code == 0
    said = done.stdout.splitlines()
    assert said[-1] == f"{path}: ok"
    assert len(said) == 1 + warned
    if warned:
        assert re.search(
            r"mine\.toml: warning: gravity\.g = \[0, 0, 9\.81\] m/s2 points up", said[0]
        )


def test_check_of_a_truth_file_looks_at_its_machine_too(tmp_path: Path) -> None:
    text = TRUTH.read_text(encoding="utf-8")
    alone, paired = tmp_path / "wild-truth.toml", tmp_path / "mine-truth.toml"
    alone.write_text(text, encoding="utf-8")
    assert check_file(alone) == [
        f"{alone}: a truth file without its machine file: name it <machine>-truth.toml"
    ]
    written(tmp_path, lambda t: t)
    paired.write_text(text, encoding="utf-8")
    assert check_file(paired) == []
    paired.write_text(replace("rms = { value = 0.0055", "rms = { value = -1")(text))
    assert check_file(paired) == [f"{paired}: cogging.rms: -1.0 N m, must be at least 0 N m"]
    assert check_file(tmp_path / "mine.toml") == check_file(paired), "a machine's truth counts"


def test_truth_file_is_no_machine_file(tmp_path: Path) -> None:
    with pytest.raises(MachineError, match=r"tflex-truth\.toml: a truth file: .* give the machine"):
        Builder(TRUTH, tmp_path).fmus()


def test_short_trajectories_hold_whole_periods(machine: Machine) -> None:
    """The quick run's 8 s are none of 0.7 s: the reference would refuse them."""
    brisk = machine.reference.model_copy(update={"period": 0.7})
    assert whole_moves(machine, 8.0) == 8.0
    moves = whole_moves(machine.model_copy(update={"reference": brisk}), 8.0)
    assert moves == pytest.approx(8.4, abs=1e-9)


ACTUATORS = MACHINE_FILE.with_name("tflex-actuators.toml").read_text(encoding="utf-8")


def test_actuators_file_must_extend_its_machine(tmp_path: Path) -> None:
    builder = Builder(written(tmp_path, lambda t: t), tmp_path / "out")
    actuators_builder(builder)  # none is there, none is wanted
    path = tmp_path / "mine-actuators.toml"
    path.write_text(ACTUATORS.replace("tflex.toml", "mine.toml"), encoding="utf-8")
    actuators_builder(builder)
    (tmp_path / "tflex.toml").write_text(MACHINE_FILE.read_text(encoding="utf-8"))
    for text, message in (
        (ACTUATORS, r"mine-actuators\.toml: extends: wants 'mine\.toml', is 'tflex\.toml'"),
        (MACHINE_FILE.read_text(encoding="utf-8"), r"extends: wants 'mine\.toml', is None"),
        ('extends = "mine.toml"\n', r"has a platform: add `without_platform = true`"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(MachineError, match=message):
            actuators_builder(builder)

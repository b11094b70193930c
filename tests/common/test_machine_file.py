"""A machine file that does not describe a machine gets one clear message each."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine.sections import Tolerance
from flexhex.fmus.common.machine_file import load_machine
from flexhex.fmus.machine.truth import load_truth
from tests.conftest import MACHINE_FILE

Edit = Callable[[str], str]


def replace(old: str, new: str) -> Edit:
    """Replace the first `old`, which must be there."""

    def edit(text: str) -> str:
        assert old in text, f"the machine file has no {old!r} any more: adapt the test"
        return text.replace(old, new, 1)

    return edit


def drop_line(start: str) -> Edit:
    """Drop the first line that begins so."""

    def edit(text: str) -> str:
        lines = text.splitlines(keepends=True)
        k = next(i for i, line in enumerate(lines) if line.startswith(start))
        return "".join(lines[:k] + lines[k + 1 :])

    return edit


RELATIVE = '{ value = %s, unit = "1", source = "assumed" }'

CASES: dict[str, tuple[Edit, str]] = {
    "missing field": (drop_line("sigma ="), r"actuator\.sigma: is missing"),
    "missing section": (
        replace("[encoder]", "[encoders]"),
        r"encoders: is not a known key, did you mean encoder\?$",
    ),
    "unknown key": (
        replace("[encoder]\n", "[encoder]\nsteps = 3\n"),
        r"encoder\.steps: is not a known key, did you mean step\?$",
    ),
    "negative mass": (
        replace("m = { value = 0.5", "m = { value = -0.5"),
        r"bodies\.upper\.m: -0\.5 kg, must be above 0",
    ),
    "inertia not positive definite": (
        replace("value = [0.12, 0.168,", "value = [-0.12, 0.168,"),
        r"bodies\.end_effector: Ic is not positive definite",
    ),
    "impossible inertia": (
        replace("value = [0.12, 0.168, 0.12", "value = [0.12, 0.168, 0.306"),
        r"bodies\.end_effector: Ic breaks the triangle inequality",
    ),
    "does not close": (
        replace("l = { value = 0.3856425829219862", "l = { value = 0.3"),
        r"arm 1 does not close: .* 0\.385642583 m apart, geometry\.l is 0\.3 m; set l = 0\.3856425",
    ),
    "axis not a unit vector": (
        replace("axis = { value = [0.0, -1.0, 0.0]", "axis = { value = [0.0, -2.0, 0.0]"),
        r"arms\.1: axis has length 2, must be 1",
    ),
    "wrong unit": (
        replace('m = { value = 0.5, unit = "kg"', 'm = { value = 500.0, unit = "g"'),
        r"bodies\.upper\.m: is in 'g', wanted 'kg': convert",
    ),
    "bare number": (
        replace('step = { value = 1e-08, unit = "rad", source = "derived"', "step = 1e-8 #"),
        r"encoder\.step: wants \{ value = \.\.\., unit = \"rad\"",
    ),
    "unknown source": (
        replace('source = "published"', 'source = "rumour"'),
        r"source 'rumour', allowed: published",
    ),
    "not a number": (
        replace("m = { value = 0.5", "m = { value = nan"),
        r"bodies\.upper\.m: nan is not a finite number",
    ),
    "wrong length": (
        replace("k_u = { value = [0.45, 0.5]", "k_u = { value = [0.45]"),
        r"flexures\.k_u: wants 2 entries, has 1",
    ),
    "five arms of actuator": (
        replace("o = { value = [-1.5, ", "o = { value = ["),
        r"actuator\.o has 5 entries for 6 arms",
    ),
    "sample time not whole": (
        replace("feedforward = { value = 0.0005", "feedforward = { value = 0.0006"),
        r"timing: feedforward is 2\.4 base steps, must be a whole number",
    ),
    "drive delay not whole": (
        replace("t_command = { value = 0.0", "t_command = { value = 0.0003"),
        r"drive\.t_command is 1\.2 base steps, must be a whole number",
    ),
    "no section": (
        replace("[encoder]\nstep", "[drive.encoder]\nstep"),
        r"encoder: is missing: add a table \[encoder\] with step",
    ),
    "five arms": (
        lambda text: "[[arms]]".join(text.split("[[arms]]")[:-2] + text.split("[[arms]]")[-1:]),
        r"arms: 5 entries, 6 wanted",
    ),
    "key of a quantity": (
        replace("m = { value = 0.5,", "m = { valeu = 0.5,"),
        r"bodies\.upper\.m: unknown key 'valeu', did you mean value\?",
    ),
    "no source": (
        replace(
            'm = { value = 0.5, unit = "kg", source = "assumed" }',
            'm = { value = 0.5, unit = "kg" }',
        ),
        r"bodies\.upper\.m: wants .*, source missing",
    ),
    "number out of bounds": (
        replace("hann_points = 101", "hann_points = 1"),
        r"control\.hann_points: is 1, must be at least 3",
    ),
    "name with blanks": (
        replace('name = "tflex"', 'name = "My Hexapod"'),
        r"name: wants small letters, .*, is 'My Hexapod'",
    ),
    "unknown tolerance": (
        replace("[drive]", "[tolerance]\nmasses = 0.1\n[drive]"),
        r"tolerance\.masses: is not a known key, did you mean mass\?$",
    ),
    "tolerance in per cent": (
        replace("[drive]", f"[tolerance]\nmass = {RELATIVE % 5}\n[drive]"),
        r"tolerance\.mass: 5\.0, must be at most 1$",
    ),
    "tolerance that holds fast": (
        replace("[drive]", f"[tolerance]\nstiffness = {RELATIVE % 0}\n[drive]"),
        r"tolerance\.stiffness: 0\.0, must be above 0$",
    ),
    "tolerance of a bare number": (
        replace("[drive]", "[tolerance]\nmass = 0.1\n[drive]"),
        r"tolerance\.mass: wants \{ value = \.\.\., unit = \"1\"",
    ),
    "no TOML": (replace("[gravity]", "[gravity"), r"not valid TOML"),
}


@pytest.mark.parametrize("case", CASES)
def test_wrong_machine_file_is_one_clear_message(case: str, tmp_path: Path) -> None:
    edit, message = CASES[case]
    path = tmp_path / "machine.toml"
    path.write_text(edit(MACHINE_FILE.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(MachineError) as caught:
        load_machine(path)
    assert re.search(message, str(caught.value)), str(caught.value)
    assert str(path) in str(caught.value)
    # at most one follow-up complaint, and no traceback of the reader
    assert len(str(caught.value).splitlines()) <= 2


def test_default_machine_file_is_accepted() -> None:
    assert load_machine(MACHINE_FILE).n_arms == 6


def test_tolerances_that_a_file_does_not_give_are_the_usual_ones(tmp_path: Path) -> None:
    edit = replace("[drive]", f"[tolerance]\nmass = {RELATIVE % 0.1}\n[drive]")
    path = tmp_path / "machine.toml"
    path.write_text(edit(MACHINE_FILE.read_text(encoding="utf-8")), encoding="utf-8")
    read, usual = load_machine(path).tolerance, load_machine(MACHINE_FILE).tolerance
    assert (read.mass, usual.mass) == (0.1, Tolerance().mass)
    assert read.model_copy(update={"mass": usual.mass}) == usual


def test_missing_machine_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MachineError, match=r"nowhere\.toml: no such file"):
        load_machine(tmp_path / "nowhere.toml")


def test_wrong_truth_file_is_one_clear_message(tmp_path: Path) -> None:
    text = MACHINE_FILE.with_name("tflex-truth.toml").read_text(encoding="utf-8")
    path = tmp_path / "truth.toml"
    edit = replace("rms = { value = 0.0055", "rms = { value = -1.0")
    path.write_text(edit(text), encoding="utf-8")
    with pytest.raises(MachineError, match=r"cogging\.rms: -1\.0 N m, must be at least 0"):
        load_truth(path)


def test_several_mistakes_are_named_at_once(tmp_path: Path) -> None:
    """A misspelt key is one line: that the right one is missing says nothing new."""
    text = MACHINE_FILE.read_text(encoding="utf-8")
    for old, new in (("value = 1.25", "value = -1.25"), ("sigma =", "sigme =")):
        assert old in text
        text = text.replace(old, new, 1)
    path = tmp_path / "machine.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(MachineError) as caught:
        load_machine(path)
    first, second = str(caught.value).splitlines()
    assert first.endswith("bodies.end_effector.m: -1.25 kg, must be above 0 kg")
    assert second.endswith("actuator.sigme: is not a known key, did you mean sigma?")

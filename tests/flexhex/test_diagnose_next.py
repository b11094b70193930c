"""What to do after a diagnosis."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path

from flexhex.diagnose.next import Invocation, next_steps, shortened
from flexhex.diagnosis.prepare import ONE_TRAJECTORY
from flexhex.diagnosis.result.estimates import Estimate, Parameter
from tests.flexhex.diagnoses import AMBIGUOUS, BASIC, CANNOT, CHANGED, NAMED, NONE, PAIR, UNKNOWN

GAIN = Estimate(1.0, (0.9, 1.1), "kg")
INVOCATION = Invocation(("flexhex", "diagnose", "run 1.csv", "--held-out", "run9.csv"))


def test_next_steps_are_commands_that_can_be_typed() -> None:
    assert next_steps(NAMED, INVOCATION)[0][1] == f"flexhex run -m {NAMED.machine}"
    again = "flexhex diagnose 'run 1.csv' --held-out run9.csv --apply"
    assert next_steps(BASIC, INVOCATION) == [
        ("Add what was found to a copy of the machine file:", again)
    ]
    separate, best = next_steps(AMBIGUOUS, INVOCATION)
    assert separate[1].startswith(
        "flexhex diagnose NEW_RUN_1 NEW_RUN_2 'run 1.csv' --held-out run9"
    )
    assert "next-coulomb_friction.csv" in separate[0]
    assert best[0].startswith("Or add the best of them")
    assert [words for _, words in next_steps(PAIR, INVOCATION)][-1].endswith("--held-out OTHER_RUN")
    assert next_steps(CHANGED, INVOCATION)[0][1] == again
    assert "--isolability" in next_steps(NONE, INVOCATION)[0][1]
    assert all("--apply" not in words for _, words in next_steps(UNKNOWN, INVOCATION))
    assert "residual maps" in next_steps(UNKNOWN, INVOCATION)[0][0]
    (alone,) = next_steps(replace(UNKNOWN, findings=(ONE_TRAJECTORY,)), INVOCATION)
    assert alone[0].startswith("Record another trajectory")
    assert alone[1].startswith("flexhex diagnose NEW_RUN_1 NEW_RUN_2 'run 1.csv'")


def test_what_was_found_in_another_machine_is_fitted_and_built() -> None:
    words = ("flexhex", "diagnose", "a.csv", "--out", "here", "--base", "arm.urdf", "--json")
    invocation = Invocation(words, "arm.urdf", "here/diagnosis.json")
    wanted = (
        "flexhex identify a.csv --base arm.urdf --diagnosis here/diagnosis.json --out identified"
        " --fmu inverse.fmu"
    )
    assert wanted in [command for _, command in next_steps(BASIC, invocation)]
    assert wanted in [command for _, command in next_steps(CHANGED, invocation)]
    # an effect of the user's own is found again by its file
    foreign = replace(BASIC, effects=(replace(BASIC.effects[0], id="gas_spring"),))
    own = replace(invocation, words=(*words, "--effect", "effect.py:GasSpring"))
    there = wanted.replace(" --diagnosis", " --effect effect.py:GasSpring --diagnosis")
    assert there in [command for _, command in next_steps(foreign, own)]


def test_logs_that_are_too_few_tell_parameters_at_least() -> None:
    words = ("flexhex", "diagnose", "a.csv", "--out", "here", "--base", "arm.urdf")
    found = replace(CANNOT, parameters=(Parameter((("m", 1.0),), GAIN, 1.0, 0.1, True),))
    commands = [command for _, command in next_steps(found, Invocation(words, "arm.urdf"))]
    assert commands[-1] == "flexhex identify a.csv --base arm.urdf"
    # of logs that cannot be fitted
    assert [command for _, command in next_steps(CANNOT, INVOCATION)] == [""]


def test_file_that_is_far_off_is_fitted_though_nothing_is_missing() -> None:
    words = ("flexhex", "diagnose", "a.csv", "--base", "arm.urdf")
    invocation, before = Invocation(words, "arm.urdf"), NONE.residual.before
    for times, there in ((2.0, False), (5.0, True)):
        far = replace(NONE, residual=replace(NONE.residual, nominal=times * before))
        commands = [command for _, command in next_steps(far, invocation)]
        assert ("flexhex identify a.csv --base arm.urdf" in commands) == there


def test_fmu_has_the_geometry_of_the_file() -> None:
    """`identify` builds none beside a geometry that it fits."""
    given = ("--tolerance", "mass=0.1", "--tolerance", "gravity=0.0005")
    words = ("flexhex", "diagnose", "a.csv", *given, "--base", "arm.urdf")
    command = Invocation(words, "arm.urdf").identify()
    assert "--tolerance mass=0.1 --base" in command


def test_effect_of_ones_own_is_written_for_any_base_model() -> None:
    words = ("flexhex", "diagnose", "a.csv", "--base", "axis")
    for invocation in (INVOCATION, Invocation(words, "axis")):
        text, command = next_steps(UNKNOWN, invocation)[0]
        assert "docs/own-effect.md" in text
        assert command == "flexhex init effect.py"


def test_logs_that_are_wrong_need_no_other_motion() -> None:
    """What to mend is the answer."""
    assert next_steps(CANNOT, INVOCATION)[0][0].startswith("Measure two trajectories")
    wrong = replace(CANNOT, notes=("axes are swapped: mend the logs, or the model",))
    assert next_steps(wrong, INVOCATION) == []


def test_files_that_a_pattern_gave_are_shown_as_that_pattern(tmp_path: Path) -> None:
    """Twenty paths, thrice, hide what is new in a command."""
    for name in ("run1.csv", "run2.csv", "run10.csv", "run2.h5", "a b.csv", "a c.csv", "a d.csv"):
        (tmp_path / name).touch()
    runs = [f"{tmp_path}/run{k}.csv" for k in (1, 10, 2)]
    held_out = f"{tmp_path}/run2.h5"
    whole = Invocation(("flexhex", "diagnose", *runs, "--held-out", held_out))
    assert whole.again("-x") == f"flexhex diagnose {tmp_path}/run*.csv --held-out {held_out} -x"
    # two of three, another order, names that the shell would split: word by word
    for words in (runs[:2], runs[::-1], [f"{tmp_path}/a {k}.csv" for k in "bcd"]):
        line = Invocation(("flexhex", "diagnose", *words)).again()
        assert shlex.split(line)[2:] == words


def test_head_of_a_page_says_how_many_files_there_are() -> None:
    """Twenty paths in a line tell nobody anything; two are still names."""
    runs = [f"data/run{k}.csv" for k in range(20)]
    words = ("flexhex", "diagnose", *runs, "--held-out", "a b.csv", "c.csv", "--base", "axis")
    assert shortened(words) == (
        "flexhex diagnose data/run*.csv, 20 files --held-out 'a b.csv' c.csv --base axis"
    )
    assert shortened(("diagnose", "a.csv", "b.csv", "c.csv")) == "diagnose *.csv, 3 files"

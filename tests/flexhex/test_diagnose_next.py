"""What to do after a diagnosis."""

from __future__ import annotations

from dataclasses import replace

from flexhex.diagnose.next import Invocation, next_steps
from flexhex.diagnosis.prepare import ONE_TRAJECTORY
from tests.flexhex.diagnoses import AMBIGUOUS, BASIC, CHANGED, NAMED, NONE, PAIR, UNKNOWN

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
        "flexhex identify a.csv --base arm.urdf --diagnosis here/diagnosis.json --fmu inverse.fmu"
    )
    assert wanted in [command for _, command in next_steps(BASIC, invocation)]
    assert wanted not in [command for _, command in next_steps(CHANGED, invocation)]

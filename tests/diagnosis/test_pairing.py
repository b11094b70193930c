"""Logs whose axes, signs or units are not the base model's are told so before any fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base, Motion
from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.result.verdict import MEND
from flexhex.diagnosis.runs.pairing import doubtful, mispaired
from flexhex.diagnosis.runs.run import Run, TimeSeries
from flexhex.diagnosis.workflow import Options, diagnose
from tests.conftest import ROOT
from tests.diagnosis.two_links import TS, moved, torque
from tests.diagnosis.two_links import run as logged

Array = NDArray[np.float64]
Change = Callable[[Array], Array]
EXAMPLE = f"{ROOT / 'flexhex/init/two_links.py'}:TwoLinks"
CLOCK = np.arange(5000) * TS
FIRST, SECOND = np.array([-1.0, 1.0]), np.array([1.0, -1.0])


def base() -> Base:
    return base_of(EXAMPLE, None, Log.of("run.csv", TS, *np.ones((2, 10, 2))))


def runs(
    angle: Change, effort: Change, load: float = 0.0, friction: float = 0.0, announced: float = 0.0
) -> list[Run]:
    """Two motions as a log would have them."""
    listed = []
    for seed in (1, 2):
        motion = moved(CLOCK, seed)
        tau = torque(motion, load, (0.3, 0.0)) + friction * np.sign(motion[1])
        valid = np.ones(len(CLOCK), dtype=bool)
        seen = Motion(0.0, TS, *(angle(v) for v in motion))
        signal = TimeSeries(0.0, TS, effort(tau), valid)
        listed.append(Run(str(seed), str(seed), seen, valid, signal, payload=announced))
    return listed


def same(values: Array) -> Array:
    return values


WRONG: dict[str, tuple[Change, Change]] = {
    "the torque of axis 1 negated": (same, lambda v: v * FIRST),
    "the angle of axis 2 negated": (lambda v: v * SECOND, same),
    "angle and torque of axis 1 negated": (lambda v: v * FIRST, lambda v: v * FIRST),
    "axes 1 and 2 exchanged": (lambda v: v[:, ::-1], lambda v: v[:, ::-1]),
    "all torques negated": (same, lambda v: -v),
    "torques of a thousandth their size": (same, lambda v: 1e3 * v),
    "angles taken as degrees": (np.rad2deg, same),
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_arrangement_is_reported_with_the_right_one(text: str) -> None:
    assert text in mispaired(base(), runs(*WRONG[text]))


RIGHT = {
    "as the file": {},
    "friction": {"friction": 3.0},
    "payload": {"load": 0.7},
    "payload announced": {"load": 3.0, "announced": 3.0},
}


@pytest.mark.parametrize("case", RIGHT)
def test_right_arrangement_is_not_doubted_for_what_is_hidden(case: str) -> None:
    assert mispaired(base(), runs(same, same, **RIGHT[case])) == ""


def test_samples_that_are_not_valid_are_no_reason() -> None:
    gone = [replace(run, valid=np.zeros_like(run.valid)) for run in runs(same, lambda v: -v)]
    assert mispaired(base(), gone) == ""


def test_diagnosis_ends_with_what_is_wrong(tmp_path: Path) -> None:
    answer = diagnose(written(tmp_path, SECOND), options=Options(base=EXAMPLE))
    assert answer.verdict == "cannot tell"
    assert "the torque of axis 2 negated" in answer.notes[-1]
    assert MEND in answer.notes[-1], "the next step is looked for by these words"


def test_doubt_is_told_before_the_search(tmp_path: Path) -> None:
    """A search takes minutes, and what it finds on another machine's logs is worth nothing."""
    told, steps = list[str](), list[str]()
    answer = diagnose(
        written(tmp_path, 2.4 * np.ones(2)),
        options=Options(base=EXAMPLE),
        progress=lambda text, done, total: steps.append(text),
        note=lambda text: told.append(f"{len(steps)}: {text}"),
    )
    (text,) = told
    assert text.startswith("2: the torque has the form")
    assert len(steps) > 3
    assert (answer.findings[0], answer.doubt) == (text[3:], text[3:])
    assert answer.confidence is None


@pytest.mark.parametrize(("load", "answered"), [(3.0, True), (0.0, False)])
def test_payload_that_was_found_answers_the_doubt(
    load: float, answered: bool, tmp_path: Path
) -> None:
    """Its torques have a form of their own; torques that are all 2.4 times as large have not,
    though a heavier last body and rotors explain them as well."""
    told = list[str]()
    times = np.ones(2) if load else 2.4 * np.ones(2)
    paths = written(tmp_path, times, load)
    answer = diagnose(paths, options=Options(base=EXAMPLE), note=told.append)
    assert "times that on axis 2: another machine's file, a payload" in told[0]
    assert {"link_2.m", "link_2.mc", "link_2.J"} == {one.parameter for one in answer.changed}
    assert (answer.doubt == "") == answered
    assert (told[0] not in answer.findings) == answered


def written(folder: Path, times: Array, load: float = 0.0) -> list[Path]:
    """Logs of two motions, each run twice, whose torques are so many times too large."""
    paths = []
    for seed, number in ((1, 1), (1, 2), (2, 1), (2, 2)):
        log = logged(seed, number, load, (0.3, 0.0))
        rows = np.column_stack([log["time"], log["theta"], log["tau_meas"] * times])
        paths.append(folder / f"{seed}_{number}.csv")
        head = "time,theta[1],theta[2],tau_meas[1],tau_meas[2]\ns,rad,rad,N m,N m"
        np.savetxt(paths[-1], rows, delimiter=",", header=head, comments="")
    return paths


GEARED = np.array([1.0, 1 / 50])
"""Torques of motors, of which the second is before its gear."""


def test_torques_of_motors_before_their_gears_are_pointed_out_with_the_factor() -> None:
    """Not refused: other masses than the file's may be the reason as well."""
    listed = runs(same, lambda v: v * GEARED)
    assert mispaired(base(), listed) == ""
    assert "0.02 times that on axis 2" in doubtful(base(), listed)


def test_factor_beside_another_arrangement_is_refused_with_both() -> None:
    said = mispaired(base(), runs(same, lambda v: v * GEARED * FIRST))
    assert "with the torque of axis 1 negated and the torque of axis 2 times 50 (a current" in said


MOSTLY_FRICTION = 20.0
"""Five times what the links need at the first axis, fifteen times at the second, RMS [N m]."""


@pytest.mark.parametrize("text", ["axes 1 and 2 exchanged", "the torque of axis 1 negated"])
def test_wrong_arrangement_is_refused_where_friction_is_most_of_the_torque(text: str) -> None:
    assert text in mispaired(base(), runs(*WRONG[text], friction=MOSTLY_FRICTION))


def test_right_arrangement_is_silent_where_friction_is_most_of_the_torque() -> None:
    listed = runs(same, same, friction=MOSTLY_FRICTION)
    assert (mispaired(base(), listed), doubtful(base(), listed)) == ("", "")


def test_file_that_makes_it_worse_than_friction_alone_is_doubted() -> None:
    """The torque has nothing of the file's links: little beside friction; nothing mends it."""
    listed = [
        replace(run, tau=replace(run.tau, values=MOSTLY_FRICTION * np.sign(run.motion.thetad)))
        for run in runs(same, same)
    ]
    assert mispaired(base(), listed) == ""
    said = doubtful(base(), listed)
    assert said.startswith("the values of the base model, friction and rotors leave ")
    assert "; friction and rotors alone leave less on ax" in said


def test_file_that_hardly_matters_beside_what_friction_leaves_is_not_doubted() -> None:
    """Friction of another form leaves three hundredths of the mean square, the links add less than
    that."""
    rng = np.random.default_rng(6)
    listed = [
        replace(run, tau=replace(run.tau, values=MOSTLY_FRICTION * (np.sign(rate) + form)))
        for run in runs(same, same)
        for rate in [run.motion.thetad]
        for form in [np.repeat(rng.normal(0, 0.17, (len(rate) // 50, 2)), 50, axis=0)]
    ]
    assert doubtful(base(), listed) == ""


def test_angles_exchanged_alone_are_reported() -> None:
    said = mispaired(base(), runs(lambda v: v[:, ::-1], same))
    assert "with the angles of axes 1 and 2 exchanged" in said


@pytest.mark.parametrize("times", [2.4, 0.45])
def test_file_of_another_machine_is_told_by_the_size_of_its_torques(times: float) -> None:
    """Of another size, but of the same form: a fit would find other masses, and a delay. On the
    first axis a rotor explains as much."""
    assert mispaired(base(), runs(same, lambda v: times * v)) == ""
    assert doubtful(base(), runs(same, lambda v: times * v)).startswith(
        "the torque has the form that the base model's values give, but is"
        f" {times:.2g} times that on axis 2: another"
    )
    assert doubtful(base(), runs(same, lambda v: 1.5 * v)) == ""


def test_arrangement_that_takes_the_torques_to_nothing_is_no_remedy() -> None:
    """A quarter turn of an angle leaves much; taken as degrees the angle hardly moves, and friction
    explains most of what is left: no reason to speak of degrees."""
    shifted = runs(same, same)
    for run in shifted:
        run.motion.theta[:, 0] += np.pi / 2
    assert mispaired(base(), shifted) == ""
    said = doubtful(base(), shifted)
    assert "less would be left with 90 degrees taken from the angle of axis 1" in said


def test_axis_whose_torque_never_changes_is_named(tmp_path: Path) -> None:
    paths = []
    for seed in (1, 2):
        run = logged(seed, 1, 0.0, (0.0, 0.0))
        rows = np.column_stack([run["time"], run["theta"], run["tau_meas"] * (1.0, 0.0)])
        names = "time,theta[1],theta[2],tau_meas[1],tau_meas[2]\ns,rad,rad,N m,N m"
        paths.append(tmp_path / f"{seed}.csv")
        np.savetxt(paths[-1], rows, delimiter=",", header=names, comments="", fmt="%.9g")
    diagnosis = diagnose(paths, options=Options(EXAMPLE))
    assert diagnosis.verdict == "cannot tell"
    assert diagnosis.notes[0].startswith("the torque of axis 2 is the same number all the time")


def test_times_that_are_wrong_are_not_reported_as_degrees() -> None:
    """Three times too fast, the torques calculated are far too large, but of the same form; angles
    in degrees would make next to none of them."""
    listed = []
    for run in runs(same, same):
        m = run.motion
        listed.append(replace(run, motion=Motion(0.0, TS, m.theta, 3 * m.thetad, 9 * m.thetadd)))
    assert mispaired(base(), listed) == ""
    assert "or times that are wrong?" in doubtful(base(), listed)

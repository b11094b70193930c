"""An axis that slides is diagnosed as one that turns, with other units, whatever its size."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

from flexhex.diagnose.effects import effect_rows
from flexhex.diagnose.view import residual_rows, residual_title
from flexhex.diagnose.words import verdict
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.kinds import LINEAR, ROTARY
from flexhex.diagnosis.logs import read_log
from flexhex.diagnosis.planning.experiment import Limits, make
from flexhex.diagnosis.planning.trajectory import read_trajectory, write_trajectory
from flexhex.diagnosis.prepare import run_set_of
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.fmus.common.effects import Experiment
from flexhex.fmus.common.errors import LogError
from tests.diagnosis.lwa4p import FILE
from tests.diagnosis.sliding import SPRING, write

slides = pytest.mark.sample(2, of="machines that slide")

SLIDES = ("m", "N")
FRICTION, COGGING = 0.1, 0.05
HIDDEN = {"nothing": (0.0, 0.0), "friction": (FRICTION, 0.0), "cogging": (0.0, COGGING)}


@cache
def said(
    hidden: str,
    units: tuple[str, str] = SLIDES,
    written: tuple[float, float] = (1.0, 1.0),
) -> Diagnosis:
    """The answer for one axis; written: by which the numbers in the files are larger."""
    friction, cogging = HIDDEN[hidden]
    paths = write(Path(mkdtemp()) / "runs", units, (friction,), (cogging,), written)
    options = Options(base="axis")
    return diagnose(paths[:4], paths[4:], options=options)


def names(diagnosis: Diagnosis) -> tuple[object, ...]:
    """What an answer says, without its numbers."""
    return diagnosis.verdict, [(e.id, e.axes, e.rivals) for e in diagnosis.effects]


@slides
def test_what_is_hidden_is_what_is_named() -> None:
    """Otherwise the comparisons below compare nothing."""
    assert names(said("nothing")) == ("none", [])
    assert names(said("friction")) == ("named", [("coulomb_friction", (1,), ())])
    (effect,) = said("friction").effects
    assert effect.parameters["F_c"].value == pytest.approx(FRICTION, rel=0.02)


@slides
@pytest.mark.parametrize("hidden", HIDDEN)
def test_the_same_numbers_as_angles_or_as_lengths_give_the_same_answer(hidden: str) -> None:
    turning, sliding = said(hidden, ("rad", "N m")), said(hidden)
    assert names(turning) == names(sliding)
    assert (turning.residual.unit, sliding.residual.unit) == ("N m", "N")
    for one, other in zip(turning.effects, sliding.effects, strict=True):
        for name, value in one.parameters.items():
            theirs = other.parameters[name]
            assert theirs.unit == LINEAR.unit(value.unit)
            # an axis that turns has two terms of gravity more
            near = 0.02 * abs(value.value) + 0.5 * (value.ci95[1] - value.ci95[0])
            assert theirs.value == pytest.approx(value.value, abs=near)
    assert [m.unit for m in sliding.maps] == [LINEAR.unit(m.unit) for m in turning.maps]
    assert {m.residual for m in sliding.maps} == {"N"}
    assert sliding.maps[0].over == "position"


@slides
@pytest.mark.parametrize("units", [("mm", 1e3), ("um", 1e6)])
@pytest.mark.parametrize("hidden", HIDDEN)
def test_millimetres_give_the_same_answer_as_metres(hidden: str, units: tuple[str, float]) -> None:
    """But for the rounding of a number that is multiplied and divided."""
    one, other = said(hidden), said(hidden, (units[0], "N"), (units[1], 1.0))
    assert names(one) == names(other)
    assert other.residual.after == pytest.approx(one.residual.after, rel=1e-6)
    for mine, theirs in zip(one.effects, other.effects, strict=True):
        for name, value in mine.parameters.items():
            half = 0.5 * (value.ci95[1] - value.ci95[0])
            near = 1e-6 * abs(value.value) + 1e-4 * half
            assert theirs.parameters[name].value == pytest.approx(value.value, abs=near)


@slides
@pytest.mark.parametrize("scale", [1e3, 1e-3])
@pytest.mark.parametrize("hidden", HIDDEN)
def test_the_same_mass_on_a_longer_way_gives_the_same_answer(hidden: str, scale: float) -> None:
    """All lengths and forces larger by a factor: a mass stays what it is."""
    one, other = said(hidden), said(hidden, SLIDES, (scale, scale))
    assert names(one) == names(other)
    assert other.residual.after == pytest.approx(scale * one.residual.after, rel=1e-3)
    for mine, theirs in zip(one.effects, other.effects, strict=True):
        for name, times in (("F_c", scale), ("s_0", scale), ("a", scale), ("order", 1 / scale)):
            if name in mine.parameters:
                value = times * mine.parameters[name].value
                assert theirs.parameters[name].value == pytest.approx(value, rel=1e-3)


@slides
def test_a_machine_of_both_kinds_has_the_units_of_each_axis(tmp_path: Path) -> None:
    units = "rad, mm", "N m, kN"
    paths = write(tmp_path / "runs", units, (FRICTION, 0.0), (0.0, COGGING))
    options = Options(base="axis")
    diagnosis = diagnose(paths[:4], paths[4:], options=options)
    units_of = {
        (e.id, e.axes): {name: value.unit for name, value in e.parameters.items()}
        for e in diagnosis.effects
    }
    assert units_of == {
        ("coulomb_friction", (1,)): {"F_c": "N m", "s_0": "rad", "v_0": "rad/s"},
        ("cogging_harmonic", (2,)): {"a": "N", "b": "N", "order": "1/m"},
    }
    data = diagnosis.data()["residual"]
    assert (data["unit"], data["before"]) == (None, None)
    assert [data["per_axis"][axis]["unit"] for axis in "12"] == ["N m", "N"]
    assert "[" not in residual_title(diagnosis.residual)
    assert [row[0] for row in residual_rows(diagnosis)] == ["1 [N m]", "2 [N]"]
    shown = {row[1]: row[2] for row in effect_rows(diagnosis)}
    assert " N m" in shown["axis 1"]
    assert " 1/m" in shown["axis 2"]
    assert " N m" not in shown["axis 2"]
    assert verdict(diagnosis)


def test_terms_of_a_slide_are_those_of_a_mass() -> None:
    """Along a line gravity is the same everywhere: no sine of a length."""
    paths = write(Path(mkdtemp()) / "runs", SLIDES)
    base, run_set, trouble = run_set_of(paths, [], None, Options(base="axis"))
    assert not trouble
    assert {k.name: k.unit for k in base.linear} == {
        "o[1]": "N",
        "m[1]": "kg",
        "d[1]": "N s/m",
        "k[1]": "N/m",
    }
    model, _, _ = fitted(base, run_set.runs)
    spring = [k.name for k in base.linear].index("k[1]")
    assert model.fitted.p[spring] == pytest.approx(SPRING, rel=0.01)


def test_a_slide_is_refused_by_a_model_that_turns(tmp_path: Path) -> None:
    pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
    paths = write(tmp_path / "runs", SLIDES, (0.0,) * 6, (0.0,) * 6)
    with pytest.raises(LogError, match=r"axis 1 is linear .* that of the base model is rotary"):
        diagnose(paths[:2], options=Options(base=str(FILE)))


def test_experiment_of_a_slide_is_in_proportion_to_its_stroke(tmp_path: Path) -> None:
    paths = write(tmp_path / "runs", ("rad, m", "N m, N"), (0.0, 0.0), (0.0, 0.0), (50.0, 1.0))
    limits = Limits.of_logs([read_log(path) for path in paths])
    plan = make(Experiment("triangle", {"speed": 0.05, "amplitude": 0.1}), limits)
    (turn, slide), reach = np.ptp(plan.r, axis=0) / 2, limits.reach
    assert turn == pytest.approx(0.1, rel=0.01)
    assert slide == pytest.approx(0.5 * reach[1], rel=0.01)
    path = write_trajectory(plan, tmp_path / "next.csv")
    assert read_trajectory(path).kinds == (ROTARY, LINEAR)

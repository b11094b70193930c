"""A limit that the reports do not show: what goes beyond it moves nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnose.effects import effect_rows, undetermined
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.jointfit.answer import joint
from flexhex.diagnosis.jointfit.effects import Part, SelectedEffect
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.result.naming import named_of, unnamed_parts
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.selection.evidence import tried
from flexhex.diagnosis.selection.moments import Moments
from flexhex.diagnosis.selection.select import select
from flexhex.diagnosis.workflow import diagnose
from flexhex.fmus.common.effects import library
from tests.diagnosis.single import write
from tests.diagnosis.test_evidence import effect_of, rows_of
from tests.diagnosis.test_selection import names
from tests.diagnosis.usual import usual

Array = NDArray[np.float64]
TS, SECONDS, J, LIMIT, SPRING = 1e-3, 12.0, 0.08, 2.0, 3.0
SHARP = library()["torque_saturation"].behind


def pushed(seed: int, limit: float) -> tuple[Array, Array]:
    """Angle and commanded torque (samples,) of an inertia on a spring with some damping, exact for
    a torque that is held over each sample; the joint gets no more than the limit."""
    rng = np.random.default_rng([seed, 3])
    t = TS * np.arange(round(SECONDS / TS))
    w, phase = rng.uniform(1.5, 14.0, 5), rng.uniform(0, 2 * np.pi, 5)
    commanded = 0.9 * np.sin(w * t[:, None] + phase).sum(axis=1)
    A = np.array([[0.0, 1.0, 0.0], [-SPRING / J, -3.0, 1 / J], [0.0, 0.0, 0.0]]) * TS
    step, term = np.eye(3), np.eye(3)
    for k in range(1, 12):
        term = term @ A / k
        step = step + term
    state, angle = np.zeros(2), np.empty(len(t))
    for k, torque in enumerate(np.clip(commanded, -limit, limit)):
        angle[k] = state[0]
        state = step[:2, :2] @ state + step[:2, 2] * torque
    return angle, commanded


def log(folder: Path, seed: int, number: int, limit: float) -> Path:
    """One pass as a file, with noise of its own; the report is the command."""
    angle, commanded = pushed(seed, limit)
    rng = np.random.default_rng([seed, number])
    seen = angle + 1e-6 * rng.standard_normal(len(angle))
    # a torque that is held acts half a sample later than its stamp
    reported = commanded + 0.01 * rng.standard_normal(len(angle))
    clock = TS * (np.arange(len(angle)) + 0.5)
    rows = np.stack([clock, np.interp(clock, clock - TS / 2, seen), reported, commanded], axis=1)[
        :-1
    ]
    head = f"# trajectory: {seed}\n# pass: {number}\n"
    head += "time,theta[1],tau_meas[1],tau[1]\ns,rad,N m,N m\n"
    path = folder / f"{seed}{number}.csv"
    with path.open("w") as file:
        file.write(head)
        np.savetxt(file, rows, fmt="%.8g", delimiter=",")
    return path


@pytest.mark.parametrize(("limit", "named"), [(LIMIT, ["torque_saturation"]), (99.0, [])])
def test_limit_is_named_where_the_motion_shows_it(
    tmp_path: Path, limit: float, named: list[str]
) -> None:
    assert SHARP is not None
    paths = [log(tmp_path, seed, number, limit) for seed in (1, 2) for number in (1, 2)]
    base, run_set, trouble = run_set_of(paths, [], None, Options(base="axis"))
    assert not trouble
    model, _, _ = fitted(base, run_set.runs)
    effects = {**library(), SHARP.id: SHARP}
    selection = select(Bench(model, compiled(1, effects, model.base.holds)))
    assert names(selection) == named
    for accepted in selection.accepted:
        hypothesis: Any = accepted.score.hypothesis
        assert hypothesis.shapes[accepted.score.shape]["tau_lim"] == pytest.approx(limit, rel=0.02)


@pytest.mark.parametrize(("lost", "said"), [(1.0, ["tau_lim"]), (0.5, ["clip", "tau_lim"])])
def test_only_what_says_something_of_a_limit_is_told(
    lost: float, said: list[str], tmp_path: Path
) -> None:
    """Its corner was not searched, and that it takes all beyond is what a limit does."""
    assert SHARP is not None
    paths = [log(tmp_path, seed, number, LIMIT) for seed in (1, 2) for number in (1, 2)]
    base, run_set, _ = run_set_of(paths, [], None, Options(base="axis"))
    model, _, _ = fitted(base, run_set.runs)
    bench = Bench(model, compiled(1, {SHARP.id: SHARP}, model.base.holds))
    part = Part.of(bench, SHARP.id, 0, {"tau_lim": LIMIT, "p": 400.0})
    fit = joint(bench, [SelectedEffect(SHARP.id, (part,))])
    fit = replace(fit, beta=(lost * fit.beta[0],))
    (effect,) = named_of(fit, [0.0])
    assert list(effect.data()["parameters"]) == ["clip", "tau_lim", "p"]
    assert [name for name, one in effect.parameters.items() if one.told] == said
    (note,) = unnamed_parts(fit, [0])
    assert ("p 400" in note, "clip" in note) == (False, "clip" in said)
    residual: Any = SimpleNamespace()
    diagnosis = Diagnosis("named", (effect,), (), residual)
    ((_, _, values, _),) = effect_rows(diagnosis)
    assert [text.split(" = ")[0] for text in values.split(", ")] == said
    assert not undetermined(diagnosis)


def test_what_the_motion_does_not_show_is_paid_for() -> None:
    """Half of the rows tell nothing but the torque's own size: log of noise over torque each."""
    rng = np.random.default_rng(5)
    rows = rows_of(rng.normal(size=240), np.zeros((240, 1)), np.ones(1), np.arange(240) // 80)
    taken = (np.arange(240) % 2).astype(float)
    plain = effect_of(np.zeros((240, 1)))
    assert np.allclose(plain.blind(rows, None, np.ones((1, 1))), 0.0)
    limit: Any = effect_of(rng.normal(size=(240, 1)))
    object.__setattr__(limit, "taken", lambda _: taken)
    object.__setattr__(limit, "low", np.ones(1))
    object.__setattr__(limit, "high", np.ones(1))
    lost = np.log(1 / rows.white_rms[0])
    assert limit.blind(rows, None, np.ones((1, 1)))[0] == pytest.approx(120 * lost)
    assert limit.blind(rows, 0, np.ones((1, 1)))[0] == pytest.approx(80 * lost)
    assert tried(Moments(rows), limit)[None].gains[0, 0] == 1.0


def test_a_limit_below_the_usual_torque_is_none() -> None:
    assert SHARP is not None
    bench: Any = SimpleNamespace(effect=SHARP)
    scales = replace(usual({SHARP.id: bench}), peaks=(4.0,), usual=(1.5,))
    sized = [scales.sized(SHARP.id, 0, {"tau_lim": share}) for share in (0.3, 0.4)]
    assert sized == [{"tau_lim": 1.2}, {"tau_lim": 1.6}]
    assert [scales.possible(SHARP.id, 0, shape) for shape in sized] == [False, True]
    assert scales.ranges(SHARP.id, 0)["tau_lim"].low == 1.5


def test_weight_is_no_limit(tmp_path: Path) -> None:
    """An axis that holds eighty times what moves it, with friction: a limit below its weight would
    leave a torque that never changes."""
    paths = [
        write(tmp_path / f"{seed}{number}.csv", seed, number, 0.1, extra=80.0)
        for seed in (1, 2, 3)
        for number in (1, 2)
    ]
    diagnosis = diagnose(paths[:4], paths[4:], options=Options(base="axis"))
    assert [effect.id for effect in diagnosis.effects] == ["coulomb_friction"]

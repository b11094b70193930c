"""What a file states beside a fit: as it says, changed, missing, or not determined.

The fits are of `examples/robot`'s logs, with the effects that the arm has by chosen shapes: no
search, so that each rule is asked by itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from flexhex.diagnosis.basemodels.base import Stated
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.hypotheses.compiled import compiled
from flexhex.diagnosis.hypotheses.own_effect import sought
from flexhex.diagnosis.jointfit.answer import Joint, joint
from flexhex.diagnosis.jointfit.effects import Part, SelectedEffect
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.result.naming import named_of
from flexhex.diagnosis.result.verdict import Named
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.stated import Compared, compared
from flexhex.fmus.common.machine.effect_use import EffectUse
from tests.conftest import ROOT

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
EXAMPLE = ROOT / "examples" / "robot"
RUNS = [EXAMPLE / f"{name}.csv" for name in ("a1", "a2", "b1", "b2")]
DRY, VISCOUS, RIPPLE, PER_TURN = (0.8, 1.5, 0.5), (0.6, 0.9, 0.3), 0.25, 18.0
SHARP = {"s_0": 1e-4, "v_0": 0.02}
Effects = Sequence[tuple[str, int, Mapping[str, float]]]
HAS: Effects = [
    *(("coulomb_friction", axis, SHARP) for axis in (1, 2, 3)),
    *(("viscous_friction", axis, {}) for axis in (1, 2, 3)),
    ("cogging_harmonic", 3, {"order": PER_TURN}),
]
"""What the arm has: ids, axes, shapes."""


@pytest.fixture(scope="module")
def model() -> Calibrated:
    options = Options(str(EXAMPLE / "arm.urdf"))
    base, run_set, _ = run_set_of(RUNS, (), None, options)
    return fitted(base, run_set.runs)[0]


def fit(model: Calibrated, uses: Sequence[EffectUse], effects: Effects = HAS) -> Joint:
    """Effects fitted beside a base model whose file states some."""
    base = copy(model.base)
    base.stated = Stated(tuple(uses), 0.1)
    bench = Bench(replace(model, base=base), compiled(base.n, sought({})))
    parts = [Part.of(bench, id, axis - 1, dict(shape)) for id, axis, shape in effects]
    return joint(bench, [SelectedEffect(part.id, (part,)) for part in parts])


def asked(made: Joint, but: Sequence[int] = ()) -> Compared:
    """What is said of it; but: places of parts without a name."""
    named = named_of(made, [0.05] * len(made.parts), but)
    return compared(made, named, (), USUAL)


def friction(dry: Sequence[float] = DRY) -> EffectUse:
    return EffectUse.of("coulomb_friction", [1, 2, 3], F_c=dry, s_0=1e-3)


def ids(named: Sequence[Named]) -> list[tuple[str, tuple[int, ...]]]:
    return [(one.id, one.axes) for one in named]


def test_what_agrees_is_no_finding_and_what_does_not_is_a_change(model: Calibrated) -> None:
    done = asked(fit(model, [friction((0.8, 3.0, 0.5))]))
    found = [("cogging_harmonic", (3,)), ("viscous_friction", (1, 2, 3))]
    assert sorted(ids(done.named)) == found
    (change,) = done.changed
    assert (change.parameter, change.nominal) == ("F_c[2]", 3.0)
    assert change.estimate.ci95[0] < DRY[1] < change.estimate.ci95[1]
    assert done.as_said == {"Coulomb friction": [0, 2]}


def test_a_wave_of_another_order_is_another_effect(model: Calibrated) -> None:
    """That of the file is one that the arm has not, and each has a number of its own."""
    waves = [
        EffectUse.of("cogging_harmonic", [3], a=0.0, b=0.3, order=order) for order in (11.0, 18.01)
    ]
    done = asked(fit(model, [friction(), *waves]))
    assert ids(done.named) == [("viscous_friction", (1, 2, 3))]
    assert [change.parameter for change in done.changed] == ["cogging_harmonic.b[3]"]
    second = asked(fit(model, [friction(), *reversed(waves)]))
    assert [change.parameter for change in second.changed] == ["cogging_harmonic_2.b[3]"]


def test_a_part_without_a_name_is_not_fitted_twice(model: Calibrated) -> None:
    """The friction of axis 1 has lost its name, that of axis 2 stays; both are as the file says."""
    done = asked(fit(model, [friction()]), but=[0])
    assert done.changed == []
    assert done.as_said["Coulomb friction"] == [0, 1, 2]


def test_one_that_these_runs_cannot_tell_from_it_is_asked_for_in_its_place(
    model: Calibrated,
) -> None:
    wave = EffectUse.of("cogging_harmonic", [3], a=0.0, b=RIPPLE, order=PER_TURN)
    other = [e for e in HAS if e[0] != "cogging_harmonic"]
    made = fit(model, [friction(), wave], [*other, ("torque_ripple", 3, {"order": PER_TURN})])
    named = [
        replace(one, rivals=("cogging_harmonic",), open=one.axes)
        if one.id == "torque_ripple"
        else one
        for one in named_of(made, [0.05] * len(made.parts))
    ]
    done = compared(made, named, (), USUAL)
    assert "torque_ripple" not in [one.id for one in done.named]
    assert done.changed == []
    assert done.as_said["cogging harmonic"] == [2]


def test_further_gains_that_the_runs_have_not_are_changes(model: Calibrated) -> None:
    """The file has a breakaway torque, the runs show none."""
    stribeck = EffectUse.of(
        "stribeck_friction", [2], F_c=DRY[1], F_s=1.2, s_0=1e-4, v_s=0.1, v_0=0.02
    )
    plain = EffectUse.of("coulomb_friction", [1, 3], F_c=[DRY[0], DRY[2]], s_0=1e-3)
    done = asked(fit(model, [stribeck, plain]))
    assert "coulomb_friction" not in [one.id for one in done.named]
    assert [change.parameter for change in done.changed] == ["stribeck_friction.F_s[2]"]


def test_one_that_has_the_file_s_in_its_gains_is_missing(model: Calibrated) -> None:
    other = [e for e in HAS if e[:2] != ("coulomb_friction", 2)]
    shape = {**SHARP, "v_s": 0.1}
    done = asked(fit(model, [friction()], [*other, ("stribeck_friction", 2, shape)]))
    assert ("stribeck_friction", (2,)) in ids(done.named)
    assert done.as_said["Coulomb friction"] == [0, 2]


def test_what_the_runs_cannot_tell_is_not_confirmed(model: Calibrated) -> None:
    mode = EffectUse.of("flexible_mode", [1], J_2=1e-4, f=45.0, zeta=0.05)
    done = asked(fit(model, [friction(), mode]))
    assert done.changed == []
    assert done.untold == {"flexible mode": [0]}
    assert "not determined by these runs: flexible mode on axis 1" in done.notes[1]


def test_sizes_are_those_of_gains_in_one_unit(model: Calibrated) -> None:
    """A stiff spring does not hide the error of an offset."""
    spring = EffectUse.of("linear_stiffness", [3], o=5.0, k_1=400.0)
    made = fit(model, [spring], [*HAS, ("linear_stiffness", 3, {})])
    changed = {change.parameter for change in asked(made).changed}
    assert changed == {"linear_stiffness.o[3]", "linear_stiffness.k_1[3]"}


def test_axes_of_which_more_remains_say_nothing(model: Calibrated) -> None:
    made = fit(model, [friction((0.8, 9.0, 0.5))], [e for e in HAS if e[1] != 2])
    named = named_of(made, [0.05] * len(made.parts))
    assert compared(made, named, {1}, USUAL).changed == []
    (change,) = compared(made, named, (), USUAL).changed
    assert change.parameter == "F_c[2]"
    assert np.isfinite(change.estimate.value)

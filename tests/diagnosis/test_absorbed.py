"""A wrong motor constant is named where one number explains what many parameters would have to.

Two axes with six parameters each; the torque of an axis is the sum of all its columns, so that an
error of its motor constant is a change of all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.absorbed import GAIN, WARM, absorbed
from flexhex.diagnosis.base import Known
from flexhex.diagnosis.calibrate import LOOSE
from flexhex.diagnosis.compiled import compiled
from flexhex.diagnosis.regression import Columns, Regression
from flexhex.diagnosis.scored import Found, Scored
from tests.diagnosis.rowsets import layout, signals
from tests.diagnosis.usual import usual

Array = NDArray[np.float64]
N, EACH, TOLERANCE = 2, 6, 0.03
"""Axes, parameters of an axis, relative tolerance of each."""
ROWS = layout(N)
OWN = [slice(i * EACH, (i + 1) * EACH) for i in range(N)]
KNOWN = tuple(
    Known(f"m{j}[{i + 1}]", "kg", 1.0, TOLERANCE, f"m{j}[{i + 1}]", i)
    for i in range(N)
    for j in range(EACH)
)
EFFECTS = {c.effect.id: c for c in compiled(N) if c.effect.id in (GAIN, WARM, "cable_force")}
SIZE = 12.0
"""Torque of a parameter relative to the noise of a row."""


def torques(seed: int) -> Array:
    """Torque (R, n_p) of every parameter at its nominal value, for the rows of its own axis."""
    found = SIZE * signals(ROWS, len(KNOWN), seed)
    for i, own in enumerate(OWN):
        found[ROWS.axis != i, own] = 0.0
    return found


def found(off: dict[str, float], gains: Sequence[float], seed: int = 0, **more: Any) -> Any:
    """What is said where parameters differ by `off` [tolerances] and motors by `gains`."""
    rng = np.random.default_rng([5, seed])
    torque = torques(seed)
    q = np.array([TOLERANCE * off.get(k.name, 0.0) for k in KNOWN])
    torque[:, 0] *= more.get("heavy", 1.0)
    loss = np.array(gains)[ROWS.axis] * torque.sum(axis=1)
    loss[ROWS.cluster % more.get("seldom", 1) != 0] = 0.0
    y = torque @ q + loss + rng.standard_normal(len(torque))
    scale = LOOSE * TOLERANCE
    made = SimpleNamespace(
        noise=SimpleNamespace(repeats=more.get("repeats", True)),
        regression=Regression(y, torque * scale, np.ones(len(KNOWN)), ROWS),
        known=KNOWN,
        base=SimpleNamespace(directions=dict),
    )

    def columns(id: str, axis: int, shape: dict[str, float]) -> Columns:
        rows = ROWS.rows(axis)
        tau = torque[rows].sum(axis=1, keepdims=True)
        instant = np.tile(np.linspace(0, 1, 600), len(tau) // 600)[:, None]
        return Columns(axis, tau if id == GAIN else tau * np.hstack([instant, instant**2]))

    bench: Any = SimpleNamespace(
        made=made, n=N, effects=EFFECTS, columns=columns, scales=usual(EFFECTS)
    )
    nothing = Columns(0, np.random.default_rng(9).standard_normal((len(torque) // N, 1)))
    others = [
        Found(id, (Scored(id, 0, {}, None, nothing),), ())  # type: ignore[arg-type]
        for id in more.get("others", ())
    ]
    return absorbed(bench, others, more.get("closed", ()))


def test_wrong_motor_constant_is_named_on_its_axis() -> None:
    named = found({}, (0.0, 0.06))
    assert (named.id, named.axes, named.rivals) == (GAIN, (1,), ())
    # 1.96 deviations of 2400 rows' noise, which is 1e-3, and of six tolerances of the parameters
    assert named.parts[0].gain.beta[0] == pytest.approx(0.06, abs=1.96 * TOLERANCE / np.sqrt(EACH))


def test_both_axes_can_have_one() -> None:
    assert sorted(found({}, (-0.08, 0.06)).axes) == [0, 1]


@pytest.mark.parametrize("name", ["m0[1]", "m3[2]"])
def test_changed_parameter_is_no_motor_constant(name: str) -> None:
    assert found({name: 8.0}, (0.0, 0.0)) is None


def test_parameter_that_makes_most_of_the_torque_is_changed_rather() -> None:
    assert found({}, (0.2, 0.0), heavy=5.0).axes == (0,)
    assert found({"m0[1]": 8.0}, (0.0, 0.0), heavy=5.0) is None


def test_what_a_second_of_each_trajectory_shows_is_none() -> None:
    assert found({}, (0.0, 2.0), seldom=30) is None


def test_parameters_within_tolerances_are_none() -> None:
    for seed in range(30):
        drawn = np.random.default_rng([6, seed]).standard_normal(len(KNOWN))
        off = {k.name: float(v) for k, v in zip(KNOWN, drawn, strict=True)}
        assert found(off, (0.0, 0.0), seed) is None, seed


def test_axis_that_is_closed_is_not_asked() -> None:
    assert found({}, (0.0, 0.06), closed=[1]) is None


def test_nothing_is_asked_beside_an_effect_that_is_like_it() -> None:
    assert found({}, (0.0, 0.06), others=[WARM]) is None
    assert found({}, (0.0, 0.06), others=["cable_force"]).axes == (1,)


def test_without_repeats_nothing_is_said() -> None:
    assert found({}, (0.0, 0.06), repeats=False) is None

"""What a torque at one place explains alone is not named as harmonics or springs."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
import pytest

import flexhex.diagnosis.places as places
from flexhex.diagnosis.compiled import compiled
from flexhex.diagnosis.scored import Found
from flexhex.fmus.common.effects import Signals, library
from tests.diagnosis.usual import usual

EFFECTS = {c.effect.id: c for c in compiled(2)}


def part(id: str, axis: int, gained: float) -> Any:
    return SimpleNamespace(id=id, axis=axis, gain=SimpleNamespace(outside=gained), columns=None)


def kept(
    monkeypatch: pytest.MonkeyPatch, bump: float | None, *parts: Any
) -> tuple[list[tuple[str, int]], list[str]]:
    """What stays of parts where a bump gains so much on axis 1 (from 0)."""

    def best(bench: Any, axis: int, others: Sequence[Any]) -> Any:
        shape = {"place": 0.03}
        gain = SimpleNamespace(outside=bump)
        return SimpleNamespace(gain=gain, shape=shape) if bump and axis == 1 else None

    monkeypatch.setattr(places, "_bump", best)
    notes: list[str] = []
    found = [Found(p.id, (p,), ()) for p in parts]
    bench: Any = SimpleNamespace(effects=EFFECTS, scales=usual(EFFECTS))
    left = places.without_places(bench, found, notes)
    return [(p.id, p.axis) for effect in left for p in effect.parts], notes


def test_two_harmonics_give_way_to_a_bump_that_nearly_does_as_well(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    both = part("cogging_harmonic", 1, 60.0), part("cogging_harmonic", 1, 40.0)
    left, notes = kept(monkeypatch, 91.0, *both)
    assert left == []
    assert "near 0.03 rad on axis 2" in notes[0]
    assert kept(monkeypatch, 89.0, *both) == ([("cogging_harmonic", 1)] * 2, [])


def test_one_curve_gives_way_only_to_a_bump_that_is_clearly_better(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    spring = part("cubic_stiffness", 1, 100.0)
    assert kept(monkeypatch, 124.0, spring)[0] == [("cubic_stiffness", 1)]
    assert kept(monkeypatch, 126.0, spring)[0] == []


def test_friction_and_other_axes_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = [part("coulomb_friction", 1, 10.0), part("cogging_harmonic", 0, 10.0)]
    harmonic = part("cogging_harmonic", 1, 10.0)
    left, notes = kept(monkeypatch, 1000.0, *parts, harmonic)
    assert left == [("coulomb_friction", 1), ("cogging_harmonic", 0)]
    assert len(notes) == 1


def test_curves_are_what_follows_the_angle_alone() -> None:
    curves = {name for name, item in EFFECTS.items() if places._is_curve(item)}
    assert curves == {"cogging_harmonic", "quadratic_stiffness", "cubic_stiffness", "cable_force"}
    assert set(EFFECTS) < set(library())


def test_bump_is_smooth_and_nothing_elsewhere() -> None:
    bump = places.Bump(-0.2, 0.2)
    theta = ca.SX.sym("theta")
    shape = {"place": 0.05, "width": 0.02}
    zero = ca.SX(0)
    column = bump.columns(Signals(theta, zero, zero, zero, zero, zero), zero, shape)
    f = ca.Function("f", [theta], [column, ca.jacobian(column, theta)])
    values = {t: [float(v) for v in f(t)] for t in (0.05, 0.03, 0.07, 0.1, -0.2, 0.06)}
    assert values[0.05] == [1.0, 0.0]
    assert values[0.06][0] == pytest.approx(0.75**2)
    for t in (0.03, 0.07, 0.1, -0.2):
        assert values[t] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert all(-0.2 < v < 0.2 for v in bump.shapes[0].grid)
    assert np.ptp(bump.shapes[1].grid) > 0

"""Effects that only imitate what has no name, alone and beside others."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.selection import imitated as imitated_module
from flexhex.diagnosis.selection.criteria import USUAL
from flexhex.diagnosis.selection.found import found
from flexhex.diagnosis.selection.nameless import nameless
from flexhex.diagnosis.selection.select import select
from tests.diagnosis.test_selection import RMS, bench_of, chosen, names

Array = NDArray[np.float64]
several = pytest.mark.sample(2, of="imitations")


@several
def test_waves_that_imitate_a_bump_are_not_named(tmp_path: Path) -> None:
    """Together they explain nearly all of it; one smooth function of the angle says it in fewer
    numbers. A wave itself is said better by its own name."""
    bump = chosen(tmp_path, lambda q, v, a: 0.06 * RMS * np.exp(-(((q - 0.1) / 0.15) ** 2)))
    assert "cogging_harmonic" in names(bump)
    assert bump.imitated[0].instead is not None
    assert bump.imitated[0].instead.hypothesis.id == "angle"
    assert nameless(bump, USUAL)[0].what == "angle"
    wave = chosen(tmp_path, lambda q, v, a: 0.06 * RMS * np.sin(15.0 * q))
    assert names(wave) == ["cogging_harmonic"]
    assert wave.imitated[0].instead is None


@several
@pytest.mark.parametrize(
    ("width", "name"), [(0.15, "cogging_harmonic"), (0.1, "cable_force")], ids=["wide", "narrow"]
)
def test_what_imitates_a_bump_beside_friction_is_not_named(
    width: float, name: str, tmp_path: Path
) -> None:
    """Friction keeps its name."""

    def both(q: Array, v: Array, a: Array) -> Array:
        return RMS * (0.1 * np.tanh(v / 0.01) + 0.06 * np.exp(-(((q - 0.1) / width) ** 2)))

    bench = bench_of(tmp_path, both)
    assert {*names(select(bench))} == {"coulomb_friction", name}
    side = found(bench, (), lambda text: None).side
    assert [effect.id for effect in side.named] == ["coulomb_friction"]
    assert [(rest.axis, rest.what, rest.form) for rest in side.rests] == [(1, "angle", False)]


@pytest.mark.parametrize(("dry", "width"), [(0.5, 0.08), (0.03, 0.08), (0.03, 0.03)])
def test_what_leaves_something_of_the_angle_itself_is_not_named(
    dry: float, width: float, tmp_path: Path
) -> None:
    """A cable and waves are parts of a bump beside friction, as they are functions of the angle
    themselves and leave another one. Friction is none, however much they leave."""

    def torque(q: Array, v: Array, a: Array) -> Array:
        bump = np.exp(-(((q + 0.1) / width) ** 2))
        return np.asarray(RMS * (dry * np.tanh(v / 0.01) + 0.2 * bump))

    side = found(bench_of(tmp_path, torque), (), lambda text: None).side
    assert [effect.id for effect in side.named] == ["coulomb_friction"]
    assert [(rest.axis, rest.what, rest.form) for rest in side.rests] == [(1, "angle", False)]


@several
def test_wave_and_cable_beside_friction_are_named(tmp_path: Path) -> None:
    """What has their very form is no imitation."""

    def all_of(q: Array, v: Array, a: Array) -> Array:
        cable = np.maximum(q - 0.1, 0.0)
        return RMS * (0.1 * np.tanh(v / 0.01) + 0.02 * np.sin(40.0 * q) + 0.5 * cable)

    side = found(bench_of(tmp_path, all_of), (), lambda text: None).side
    named = {effect.id for effect in side.named}
    assert named == {"coulomb_friction", "cogging_harmonic", "cable_force"}


@pytest.mark.parametrize("zero", [0.0, 1.6])
def test_cable_tightens_anywhere(zero: float, tmp_path: Path) -> None:
    """Where an axis counts its angles from says nothing about it."""
    bench = bench_of(tmp_path, lambda q, v, a: 2.0 * RMS * np.maximum(q - 0.17, 0.0), zero=zero)
    (cable,) = found(bench, (), lambda text: None).side.named
    assert cable.id == "cable_force"
    assert cable.parameters["theta_0"].value == pytest.approx(0.17 + zero, abs=0.01)


@pytest.mark.parametrize(
    ("others", "price", "fitted", "displaced"),
    [
        ((130.0, 60.0), 0.0, 0, True),
        ((130.0, 50.0), 0.0, 0, False),
        ((100.0, 60.0), 0.0, 0, True),
        ((96.5, 60.0), 0.0, 0, False),
        ((96.5, 60.0), 0.0, 1, True),
        ((100.0, 50.0), 5.0, 1, True),
    ],
    ids=[
        "both",
        "left-out runs",
        "all runs",
        "left-out runs deny it",
        "fitted to them",
        "one of many",
    ],
)
def test_effect_is_displaced_by_what_has_more_evidence(
    others: tuple[float, float],
    price: float,
    fitted: int,
    displaced: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The effect gains 100 nats on left-out runs and has an evidence of 50; something without a
    name in its place `others`, and of another kind beside either of them nothing."""

    def score(model: SimpleNamespace, listed: object) -> SimpleNamespace:
        gain, whole = others if model.bare else (0.0, 0.0)
        return SimpleNamespace(gain=gain, whole=whole, hypothesis=SimpleNamespace(id="angle"))

    rows, fit = SimpleNamespace(folds=(0,)), SimpleNamespace(sure=True)
    nothing = SimpleNamespace(bare=False, rows=rows, fit=lambda left: fit)
    bare = SimpleNamespace(bare=True, extended=lambda term: nothing)
    moments = SimpleNamespace(
        bare=False, without=lambda *terms: bare, extended=lambda term: nothing
    )
    whole = SimpleNamespace(of=lambda moments, kind: SimpleNamespace(beyond=lambda axis: 0.0))
    for name, value in {
        "together": lambda moments, terms: 100.0,
        "evidence_of": lambda moments, terms: 50.0,
        "generic_score": score,
        "generic_term": lambda moments, kind: None,
        "Whole": whole,
    }.items():
        monkeypatch.setattr(imitated_module, name, value)
    effect = SimpleNamespace(hypothesis=SimpleNamespace(id="any"), price=price, fitted=fitted)
    unnamed = SimpleNamespace(columns=SimpleNamespace(id="angle"))
    subject: Any = SimpleNamespace(
        moments=moments,
        criteria=USUAL,
        hypotheses=SimpleNamespace(
            generic=lambda axis: [unnamed],
            with_angle=lambda name: False,
        ),
        own=lambda axis: [(effect, (None, None))],
    )
    instead = imitated_module.imitated(subject, 0).instead
    assert (instead is not None) == displaced


@pytest.mark.parametrize("sure", [True, False])
def test_second_kind_is_asked_for_where_the_runs_determine_the_first(
    sure: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Left-out runs that do not make gains of the second out of noise."""
    score = SimpleNamespace(gain=9.0, whole=8.0, hypothesis=SimpleNamespace(id="angle"))
    monkeypatch.setattr(imitated_module, "generic_score", lambda moments, listed: score)
    monkeypatch.setattr(imitated_module, "generic_term", lambda moments, kind: None)
    fits = {None: True, 0: sure}
    longer = SimpleNamespace(
        rows=SimpleNamespace(folds=(0,)), fit=lambda left: SimpleNamespace(sure=fits[left])
    )
    model: Any = SimpleNamespace(extended=lambda term: longer)
    unnamed: Any = [SimpleNamespace(columns=SimpleNamespace(id="angle"))]
    first: Any = score
    gain, whole = imitated_module.of_two_kinds(model, unnamed, first)
    assert (gain, whole) == ((18.0, 16.0) if sure else (9.0, 8.0))
    # what predicts nothing is not there, whatever evidence it seems to have
    score.gain = -0.1
    assert imitated_module.of_two_kinds(model, unnamed, first) == (0.0, 0.0)

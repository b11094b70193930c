"""Invented diagnoses, one for each verdict: what the views are tested with."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flexhex.diagnosis.result.estimates import Estimate
from flexhex.diagnosis.result.pictured import Candidate, Map
from flexhex.diagnosis.result.verdict import Changed, Diagnosis, Named, Residual

N = 6
NON_REPEATABLE = np.full(N, 0.009)
TORQUE = np.array([2.1, 2.0, 1.9, 2.2, 2.0, 2.1])
QUANTITIES = (
    ("angle", "rad", 0.19),
    ("velocity", "rad/s", 1.2),
    ("acceleration", "rad/s2", 7.9),
    ("torque", "N m", 4.5),
    ("time", "s", 50.0),
    ("payload", "kg", 1.0),
)


def estimate(value: float, half: float, unit: str = "N m") -> Estimate:
    """A value with a symmetric interval."""
    return Estimate(value, (value - half, value + half), unit)


def residual(axis: int | None = 3, size: float = 0.05, left: float = 0.0) -> Residual:
    """A repeatable residual of `size` [N m] on one axis (from 1) or on all, `left` of it after."""
    shown = np.array([axis is None or i == axis - 1 for i in range(N)], dtype=float)
    repeatable, repeatable_after = size * shown, left * shown
    before, after = np.hypot(NON_REPEATABLE, repeatable), np.hypot(NON_REPEATABLE, repeatable_after)
    held_out = {
        "nominal": before * 1.2,
        "before": before,
        "after": after * 1.05,
        "non_repeatable": NON_REPEATABLE,
    }
    return Residual(
        ("N m",) * N,
        TORQUE,
        before * 1.2,
        before,
        after,
        NON_REPEATABLE,
        repeatable,
        repeatable_after,
        held_out,
    )


def coulomb(axes: tuple[int, ...] = (3,)) -> Named:
    """Coulomb friction of 0.05 N m, a little more from axis to axis."""
    parts = tuple((a, {"F_c": estimate(0.05 + 0.01 * k, 0.0031)}) for k, a in enumerate(axes))
    parts[-1][1]["v0"] = Estimate(0.002, (math.nan, math.nan), "rad/s")
    several = len(axes) > 1
    parameters = {f"{n}[{a}]" if several else n: e for a, own in parts for n, e in own.items()}
    return Named("coulomb_friction", "Coulomb friction", axes, parameters, parts, share=0.93)


def cogging() -> Named:
    """A cogging harmonic on axis 5: two gains and an order."""
    parameters = {
        "a": estimate(0.0121, 0.0008),
        "b": estimate(-0.0045, 0.0009),
        "order": estimate(29.02, 0.05, "1/rad"),
    }
    return Named("cogging_harmonic", "cogging harmonic", (5,), parameters, share=0.88)


def candidates() -> tuple[Candidate, ...]:
    """Two rounds: friction before all others, then nothing worth naming."""
    first = [("coulomb_friction", 0.93), ("stribeck_friction", 0.71), ("second_hysteresis", 0.66)]
    first += [("quadratic_drag", 0.21), ("time_delay", 0.04), ("torque_constant_saturation", 0.02)]
    listed = [
        Candidate(1, name, (3,), {}, 1e3 * gain, 0.02 * gain, chosen=k == 0, rival=k == 2)
        for k, (name, gain) in enumerate(first)
    ]
    listed += [Candidate(2, "cubic_stiffness", (1,), {}, 3.0, 2e-4)]
    listed += [Candidate(2, "cross_coupling", (2, 4), {}, -1.0, 1e-4)]
    return tuple(listed)


def maps(axes: tuple[int, ...] = (3,)) -> tuple[Map, ...]:
    """Residuals over all quantities, and the spectrum, of some axes."""
    listed, random = [], np.random.default_rng(1)
    for axis in axes:
        for over, unit, size in QUANTITIES:
            x = np.linspace(-size, size, 24) if over != "time" else np.linspace(0, size, 24)
            before = 0.05 * np.tanh(20 * x / size) if over == "velocity" else 0.004 * np.cos(3 * x)
            noise = 0.001 * random.standard_normal(24)
            listed.append(Map(axis, over, unit, x, before + noise, noise, np.full(24, 0.0015)))
        f = np.geomspace(0.1, 200, 200)
        low = 0.02 / (1 + f) + 2e-4 * random.random(200)
        listed.append(Map(axis, "frequency", "Hz", f, low, low / (1 + 9 / (1 + f)), 0 * f))
    return tuple(listed)


def shown() -> dict[str, object]:
    """Replay of a held-out run and closed loops, as `flexhex.diagnose.rebuild` gives them."""

    def loop(before: float, after: float) -> dict[str, object]:
        sides = {"before": before, "after": after}
        return {k: {"e": e, "tau_fb": e * 2e-4} for k, e in sides.items()} | {"unit": "urad, N m"}

    residuals = {"unit": "N m", "before": [0.05] * N, "after": [0.01] * N}
    return {
        "machine": "out/diagnose/machine.toml",
        "simulation_residual": {"out/run9.csv": residuals},
        "closed_loop": {"model": loop(30.1, 2.2), "machine": loop(26.4, 8.5)},
    }


FINDINGS = (
    "run1.csv: tau_meas: 14 samples clipped at 4.5 N m: not used",
    "run2.csv: theta converted from deg to rad",
)
BASIC = Diagnosis(
    "named",
    (coulomb(),),
    (),
    residual(left=0.012),
    candidates(),
    maps(),
    ("The shape v0 is not determined by these runs: its start value was kept.",),
    FINDINGS,
    ("run1.csv", "run2.csv"),
    ("run9.csv",),
)
PAYLOAD = Changed("end_effector.m", 3.2, estimate(3.71, 0.1, "kg"))
NAMED = replace(BASIC, machine="out/diagnose/machine.toml", shown=shown())
PAIR = replace(BASIC, effects=(coulomb((2, 4)), cogging()), changed=(PAYLOAD,), held_out=())
AMBIGUOUS = replace(
    BASIC,
    verdict="ambiguous",
    effects=(
        replace(
            coulomb(),
            rivals=("stribeck_friction", "second_hysteresis"),
            experiment="out/diagnose/next-coulomb_friction.csv",
            open=(3,),
        ),
    ),
)
PARTLY = replace(
    BASIC,
    verdict="ambiguous",
    effects=(replace(coulomb((2, 4)), rivals=("stribeck_friction",), open=(4,)),),
)
CHANGED = replace(BASIC, verdict="changed", effects=(), changed=(PAYLOAD,), maps=())
CARRIED = replace(
    CHANGED,
    changed=(
        Changed("payload", 0.0, estimate(0.255, 0.001, "kg"), ("out/run1.csv", "run2.csv")),
        Changed("payload.c_z", 0.0, estimate(0.0231, 0.0012, "m"), ("out/run1.csv", "run2.csv")),
    ),
)
UNKNOWN = replace(
    BASIC, verdict="unknown", effects=(), residual=residual(4, 0.031, 0.029), maps=maps((4,))
)
NONE = replace(
    BASIC, verdict="none", effects=(), residual=residual(size=0.0), candidates=(), maps=()
)
CANNOT = Diagnosis(
    "cannot tell",
    (),
    (),
    Residual(("N m",) * N, TORQUE, *(np.full(N, np.nan) for _ in range(6))),
    notes=("no trajectory was run twice, so what repeats is not known",),
    findings=FINDINGS,
    runs=("run1.csv",),
)
EXAMPLES = {
    "named": NAMED,
    "named, not applied": BASIC,
    "pair": PAIR,
    "ambiguous": AMBIGUOUS,
    "ambiguous on one axis": PARTLY,
    "changed": CHANGED,
    "payload": CARRIED,
    "unknown": UNKNOWN,
    "none": NONE,
    "cannot tell": CANNOT,
}

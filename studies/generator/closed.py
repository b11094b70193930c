"""Cases run by the closed loop: which, what became of each effect in them, and their cache."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from studies.generator import closed_loop
from studies.generator.closed_loop import Loop, Prepared, integrate, prepare
from studies.generator.draw import Case, assemble, place
from studies.generator.drives import Drive, Encoder, Motor
from studies.generator.effects import shape
from studies.generator.inverse import Clean
from studies.generator.inverse import signal as signal_of
from studies.generator.torques import Torque
from studies.generator.trajectories import RATE, WARM
from tests.oracles.calculus import Array

FIRST_SEED = 1_000_000
"""Cases of the closed loop have seeds from here on."""
SINGLES = (
    "coulomb_friction",
    "stribeck_friction",
    "quadratic_drag",
    "cogging_harmonic",
    "second_hysteresis",
    "quadratic_stiffness",
    "cubic_stiffness",
    "cable_force",
    "flexible_mode",
    "torque_constant_saturation",
    "torque_ripple",
    "cross_coupling",
    "drive_lag",
    "encoder_eccentricity",
)
"""Not here: what takes longer than a run or has no place in the loop (drifts, tilt, delay)."""
LISTED = ("", "", "", "", *SINGLES, "torque_bump", "memory_damping", "uneven_inertia", "backlash")
MODULES = (
    "base",
    "closed_loop",
    "draw",
    "drives",
    "effects",
    "inverse",
    "mechanism",
    "outside",
    "trajectories",
)
"""What a run depends on."""
SECONDS = 8.0
"""Length of a run [s]."""


def closed_case(number: int, seconds: float = SECONDS) -> Case:
    """Case `number`, from 0; after 22 of them the list begins again with other draws."""
    seed, id = FIRST_SEED + number, LISTED[number % len(LISTED)]
    rng = np.random.default_rng([seed, 1])
    if not id:
        return assemble(seed, "nothing", (), seconds, True)
    outside = id not in SINGLES
    size, count = float(rng.choice([0.01, 0.03])), int(rng.integers(1, 3))
    hidden = (place(rng, id, size, 1 if outside else count),)
    return assemble(seed, "outside" if outside else "single", hidden, seconds, True)


def simulate_closed(cases: Sequence[Case], cache: Path) -> list[Clean]:
    """Runs of cases of one length, integrated side by side unless they lie in the cache."""
    prepared = [prepare(case) for case in cases]
    paths = [cache / f"{_key(case)}.npz" for case in cases]
    new = [k for k, path in enumerate(paths) if not path.exists()]
    if new:
        loop = Loop([prepared[k] for k in new])
        log, steps = integrate(loop, cases[0].seconds)
        cache.mkdir(parents=True, exist_ok=True)
        for k, part in zip(new, loop.part, strict=True):
            signals = {name: values[:, part] for name, values in log.items()}
            np.savez(paths[k], steps=steps, **signals)  # type: ignore[arg-type]
    return [_clean(p, dict(np.load(path))) for p, path in zip(prepared, paths, strict=True)]


def _key(case: Case) -> str:
    """Name of a case in the cache: it changes with the case and with the code that makes it."""
    folder = Path(closed_loop.__file__).parent
    code = b"".join((folder / f"{name}.py").read_bytes() for name in MODULES)
    drawn = repr((case.hidden, case.noise, case.trajectories, case.seconds, case.seed))
    return f"{case.seed}-{hashlib.sha256(code + drawn.encode()).hexdigest()[:16]}"


def _clean(p: Prepared, log: dict[str, Array]) -> Clean:
    """The runs as the logger gets them; accelerations by differences of the rates."""
    q, v = log["q"], log["v"]
    motion = q, v, np.gradient(v, 1 / RATE, axis=-1)
    bare = p.base.torque(*motion)
    rms = np.sqrt(np.mean(bare[..., round(WARM * RATE) :] ** 2, axis=(1, 2)))
    reading, contributions = motion, []
    for s in p.scaled:
        if isinstance(s.effect, Torque):
            contributions.append(s.gain[:, None, None] * shape(s.effect, p.clock, *motion))
        elif isinstance(s.effect, Motor):
            contributions.append(log["i"] - s.effect.real(s.gain, log["i"], p.clock, q))
        elif isinstance(s.effect, Encoder):
            reading = s.effect.reading(s.gain, *reading)
            contributions.append(bare - p.base.torque(*reading))
        elif isinstance(s.effect, Drive):
            contributions.append(signal_of(s.effect, s.gain, p.base, p.clock, motion, log["i"]))
    return Clean(
        p.clock,
        *reading,
        log["i"],
        log["tau"],
        p.ref[0],
        tuple(contributions),
        p.scaled,
        rms,
        p.base,
    )

"""The whole adaptive loop: the executor against other importers."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from benchmarks.clock import Row, Timing
from flexhex.fmus.common.errors import RunError
from flexhex.simulation.builder import Builder
from flexhex.ssp.executor import run
from flexhex.ssp.results import Result

OUT = Path("out") / "benchmarks"
SECONDS, BASE = 16.0, 0.00025
"""Simulated by the executor [s] (the slower importers get less); their step [s]."""
Simulation = tuple[Callable[[float], None], float]
"""What simulates so many seconds; for how long it is asked to [s]."""


def system(machine_file: Path) -> Path:
    """The adaptive loop around the model."""
    builder = Builder(machine_file, OUT)
    builder.systems()
    return OUT / "hexapod.ssp"


def factors_in_turn(rivals: Mapping[str, Simulation], rounds: int) -> dict[str, list[float]]:
    """Simulated seconds for a second of this process's processor time, all threads together, by
    rival; a round of each in turn.

    A run of twice the time less a run of the time: what opening the archive takes drops out.
    """
    factors: dict[str, list[float]] = {name: [] for name in rivals}
    for _ in range(rounds):
        for name, (simulate, seconds) in rivals.items():
            once, twice = (_spent(simulate, k * seconds) for k in (1, 2))
            factors[name].append(seconds / (twice - once))
    return factors


def _spent(simulate: Callable[[float], None], seconds: float) -> float:
    begin = time.process_time()
    simulate(seconds)
    return time.process_time() - begin


def executor(ssp: Path, seconds: float = SECONDS, timing: bool = False) -> Result:
    """One run, logs as by default."""
    return run(ssp, seconds, timing=timing, cache=OUT / "lib")


def loop_row(machine_file: Path, rounds: int) -> Row:
    """Real-time factor of the adaptive loop, on one core."""
    ssp, notes = system(machine_file), []

    def own(seconds: float) -> None:
        executor(ssp, seconds)

    rivals: dict[str, Simulation] = {"executor": (own, SECONDS)}
    for name, of, seconds, hint in (
        ("libcosimpy", _libcosim, 2.0, "libcosimpy"),
        ("FMPy simulate_ssp", _fmpy, 0.1, "fmpy"),
    ):
        try:
            rivals[name] = of(ssp), seconds
        except ImportError:
            notes.append(f"{name} is not installed (pip install {hint})")
    factors = factors_in_turn(rivals, max(3, rounds // 5))
    timings = [
        Timing(name, float(np.median(each)), float(np.max(each))) for name, each in factors.items()
    ]
    return Row("loop", "adaptive loop, x real time", timings, 5, 12, faster=True, notes=notes)


def _fmpy(ssp: Path) -> Callable[[float], None]:
    from fmpy.ssp.simulation import simulate_ssp

    return lambda seconds: simulate_ssp(str(ssp), stop_time=seconds, step_size=BASE)


def _libcosim(ssp: Path) -> Callable[[float], None]:
    from libcosimpy.CosimExecution import CosimExecution  # type: ignore[import-untyped]
    from libcosimpy.CosimLogging import (  # type: ignore[import-untyped]
        CosimLogLevel,
        log_output_level,
    )

    # it warns on the standard output, where JSON is to stand: it ignores enumerations such as fault
    log_output_level(CosimLogLevel.ERROR)

    def simulate(seconds: float) -> None:
        execution = CosimExecution.from_ssp_file(str(ssp), round(BASE * 1e9))
        if not execution.simulate_until(round(seconds * 1e9)):
            raise RunError("libcosimpy: simulate_until failed")

    return simulate


def where(ssp: Path, runs: int = 4) -> dict[str, tuple[float, float]]:
    """Per FMU of the loop: seconds a simulated second, microseconds a step with get and set.

    By the clock, so the best of a few runs counts, FMU by FMU.
    """
    results = [executor(ssp, 2.0, timing=True) for _ in range(runs)]
    best = {
        name: min(r.times[name].seconds / r.times[name].steps for r in results)
        for name in results[0].times
    }
    steps = {name: spent.steps / results[0].duration for name, spent in results[0].times.items()}
    return {name: (each * steps[name], each * 1e6) for name, each in best.items()}

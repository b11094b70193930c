"""The whole adaptive loop: the executor against other importers, loops side by side."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from benchmarks.clock import Row, Timing
from flexhex.fmus.common.errors import RunError
from flexhex.simulation.builder import Builder
from flexhex.ssp.executor import run
from flexhex.ssp.results import Result

OUT = Path("out") / "benchmarks"
SECONDS, BASE = 4.0, 0.00025
"""Simulated by the executor [s] (the slower importers get less); their step [s]."""


def system(machine_file: Path) -> Path:
    """The adaptive loop around the model."""
    builder = Builder(machine_file, OUT)
    builder.systems()
    return OUT / "hexapod.ssp"


def _factor(simulate: Callable[[float], None], short: float, rounds: int) -> list[float]:
    """Simulated seconds for a second of this process's processor time, all threads together.

    A run of twice the time less a run of `short` [s]: what opening the archive takes drops out.
    """
    factors = []
    for _ in range(rounds):
        spent = []
        for seconds in (short, 2 * short):
            begin = time.process_time()
            simulate(seconds)
            spent.append(time.process_time() - begin)
        factors.append(short / (spent[1] - spent[0]))
    return factors


def _timing(name: str, factors: list[float], note: str = "") -> Timing:
    return Timing(name, float(np.median(factors)), float(np.max(factors)), note)


def executor(ssp: Path, seconds: float = SECONDS, timing: bool = False) -> Result:
    """One run, logs as by default."""
    return run(ssp, seconds, timing=timing, cache=OUT / "lib")


def loop_row(machine_file: Path, rounds: int) -> Row:
    """Real-time factor of the adaptive loop, on one core."""
    ssp = system(machine_file)

    def own(seconds: float) -> None:
        executor(ssp, seconds)

    timings, notes = [_timing("executor", _factor(own, SECONDS, max(3, rounds // 5)))], []
    for name, of, short, hint in (
        ("libcosimpy", _libcosim, 2.0, "libcosimpy"),
        ("FMPy simulate_ssp", _fmpy, 0.1, "fmpy"),
    ):
        try:
            timings.append(_timing(name, _factor(of(ssp), short, 3)))
        except ImportError:
            notes.append(f"{name} is not installed (pip install {hint})")
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


def side_by_side(
    ssp: Path, loops: int, cores: list[int], seconds: float = 2.0
) -> tuple[float, float]:
    """Simulated seconds of all loops for a second of the clock, and of processor time.

    Threads of one process. The clock counts what others do on the cores; processor time does
    not, and tells whether the loops are in each other's way. Best of two.
    """
    before = sorted(os.sched_getaffinity(0)) if cores else []
    if cores:
        os.sched_setaffinity(0, cores)
    try:
        times = [_threads(ssp, loops, seconds) for _ in range(2)]
    finally:
        if before:
            os.sched_setaffinity(0, before)
    return max(clock for clock, _ in times), max(spent for _, spent in times)


def _threads(ssp: Path, loops: int, seconds: float) -> tuple[float, float]:
    begin, spent = time.perf_counter(), time.process_time()
    with ThreadPoolExecutor(loops) as pool:
        total = sum(r.duration for r in pool.map(lambda _: executor(ssp, seconds), range(loops)))
    return total / (time.perf_counter() - begin), total / (time.process_time() - spent)

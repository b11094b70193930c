"""What several cores do for one: loops side by side, and beside them plain C that shares nothing.

Two cores are seldom twice one: they may be one core twice (hyperthreads), a computer's clock falls
when more of them work, and other users of the computer take their part of it. So the same is
measured of C that needs nothing but its own core, and that is what loops are to be judged by.
"""

from __future__ import annotations

import ctypes
import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from benchmarks.blocks import CACHE, HERE
from benchmarks.loop import executor
from flexhex.fmugen.compile import compile_object, link_shared

Work = Callable[[float], object]
"""Do so much of it, without Python's lock."""
ROUNDS, SECONDS, SHORT = 4, 8.0, 0.2
"""Rounds of which the best counts; simulated time of a loop [s]; time that C takes [s]."""
KINDS = {
    "registers": "parallel_registers",
    "values of 16 KiB": "parallel_values",
    "code of 64 KiB": "parallel_code",
}
"""What a core is kept busy with, and its function in parallel.c."""


def loops_side_by_side(ssp: Path, loops: int, cores: list[int]) -> tuple[float, float]:
    """Simulated seconds of all loops for a second of the clock, and of processor time."""
    return side_by_side(lambda seconds: executor(ssp, seconds), SECONDS, loops, cores)


def own(cores: list[int]) -> dict[str, float]:
    """By kind of work: two of them on two cores, as a multiple of one on one, by the clock."""
    library, gains = ctypes.CDLL(str(_library())), {}
    for kind, name in KINDS.items():
        work = _work(library, name)
        amount = _amount(work)
        one, two = (side_by_side(work, amount, count, cores[:count])[0] for count in (1, 2))
        gains[kind] = two / one
    return gains


def _work(library: ctypes.CDLL, name: str) -> Work:
    function = getattr(library, name)
    function.restype, function.argtypes = ctypes.c_double, (ctypes.c_long,)
    return lambda rounds: function(round(rounds))


def side_by_side(work: Work, amount: float, count: int, cores: list[int]) -> tuple[float, float]:
    """Work of all threads for a second of the clock, and of processor time; best of ROUNDS.

    Twice the amount less the amount, so that what one does in Python's lock before it begins drops
    out. The clock counts what others do on the cores; processor time does not, and tells whether
    the threads are in each other's way. cores: where they may run; empty for anywhere.
    """
    before = sorted(os.sched_getaffinity(0)) if cores else []
    if cores:
        os.sched_setaffinity(0, cores)
    try:
        times = [[_spent(work, k * amount, count) for k in (1, 2)] for _ in range(ROUNDS)]
    finally:
        if before:
            os.sched_setaffinity(0, before)
    clock, processor = (
        min(twice[k] for _, twice in times) - min(once[k] for once, _ in times) for k in (0, 1)
    )
    return count * amount / clock, count * amount / processor


def _spent(work: Work, amount: float, count: int) -> tuple[float, float]:
    """Time of the clock and processor time [s] of so many threads that do the amount each."""
    begin, spent = time.perf_counter(), time.process_time()
    with ThreadPoolExecutor(count) as pool:
        list(pool.map(work, [amount] * count))
    return time.perf_counter() - begin, time.process_time() - spent


def _amount(work: Work) -> float:
    """Rounds that take about SHORT."""
    rounds = 1
    while (spent := _spent(work, rounds, 1)[0]) < SHORT / 4:
        rounds *= 4
    return rounds * SHORT / spent


def _library() -> Path:
    compiled = compile_object(HERE / "parallel.c", "", CACHE, ("-O2", "-std=c99"))
    library = compiled.with_suffix(".so")
    return library if library.exists() else link_shared([compiled], library)

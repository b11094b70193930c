"""Where the runs of a study are done: processes of this computer, or the workers of dask."""

from __future__ import annotations

import importlib
import math
import multiprocessing
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from itertools import islice
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Any

from flexhex.fmus.common.errors import RunError, UsageError
from flexhex.ssp import library
from flexhex.study.store import Scored
from flexhex.study.tasks import Pool, Task, score

PATIENCE = 10.0
"""Time in which a scheduler has to answer [s]."""


def local(jobs: int) -> Pool:
    """Processes of this computer, `jobs` at a time."""
    if jobs < 1:
        raise UsageError(f"--jobs {jobs}: must be at least 1")

    def pool(tasks: Sequence[Task]) -> Iterator[tuple[Task, Scored | str]]:
        library.load()  # compiled once, before all of them want it
        context = multiprocessing.get_context("spawn")
        workers = min(jobs, len(tasks))
        with ProcessPoolExecutor(workers, mp_context=context) as executor:
            left = iter(tasks)
            # no more than run at once: Ctrl-C then waits for these alone
            waiting: dict[Future[Scored], Task] = {}
            with _without_interrupt():  # here all processes are started
                for task in islice(left, workers):
                    waiting[executor.submit(score, task)] = task
            while waiting:
                for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                    task = waiting.pop(future)
                    for following in islice(left, 1):
                        waiting[executor.submit(score, following)] = following
                    yield task, _outcome(future)

    return pool


def over_dask(address: str) -> Pool:
    """The workers of a dask scheduler; each needs flexhex, the .ssp are sent to them."""
    try:
        distributed: Any = importlib.import_module("distributed")
    except ImportError:
        raise UsageError(
            "--dask: dask.distributed is not installed: pip install 'flexhex[dask]'"
        ) from None

    def pool(tasks: Sequence[Task]) -> Iterator[tuple[Task, Scored | str]]:
        with _client(distributed, address) as client:
            paths = {task.ssp for task in tasks}
            sent = {path: client.scatter(path.read_bytes(), hash=False) for path in paths}
            futures = {client.submit(_remote, t, sent[t.ssp], pure=False): t for t in tasks}
            try:
                for future in distributed.as_completed(list(futures), loop=client.loop):
                    yield futures[future], _outcome(future)
            finally:
                client.cancel(list(futures))

    return pool


def _client(distributed: Any, address: str) -> Any:
    """A client of a scheduler that has workers; UsageError for anything else."""
    try:
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise UsageError(f"--dask {address}: no scheduler answers ({error})") from None
    if not client.scheduler_info()["workers"]:
        client.close()
        raise UsageError(f"--dask {address}: the scheduler has no workers: start `dask worker`")
    return client


def _remote(task: Task, content: bytes) -> Scored:
    """A task on a worker, whose working folder may be anywhere."""
    return score(task, content, Path.home() / ".cache" / "flexhex")


def _outcome(future: Any) -> Scored | str:
    """Figures, or why the system refused to run; any other error ends the study."""
    try:
        scored: Scored = future.result()
    except RunError as error:
        return str(error)
    except BrokenProcessPool:
        raise RunError(
            "a process of the study died, maybe for want of memory: fewer --jobs may help;"
            " finished runs are kept"
        ) from None
    finite = math.isfinite(scored.e) and math.isfinite(scored.tau_fb)
    return scored if finite else "the figures are not finite"


@contextmanager
def _without_interrupt() -> Iterator[None]:
    """Processes started meanwhile never receive Ctrl-C, not even while they import: it is for the
    main process; the others end their run and are then ended by it.

    The signal is held back, not ignored: one that comes meanwhile arrives afterwards.
    """
    resource_tracker.ensure_running()  # it would let the signal through while it starts
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

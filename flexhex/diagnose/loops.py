"""The adaptive loop closed with two models, each beside the other."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.machine_file import truth_file
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import SETTLE, table_cases
from flexhex.simulation.metrics import rms
from flexhex.ssp.executor import run

Array = NDArray[np.float64]
Say = Callable[[str], None]

MICRO = 1e6


@dataclass(frozen=True)
class Tracking:
    """Closed loop, adaptive: RMS of e [urad] and of the feedback's torque [N m], all joints."""

    e: float
    tau_fb: float


@dataclass(frozen=True)
class Model:
    """A model beside the data: its builder, fitted p with standard deviations."""

    builder: Builder
    p: Array
    std: Array | None = None


def closed_loops(
    before: Model, after: Model, seconds: float, say: Say
) -> dict[str, tuple[Tracking, Tracking]]:
    """Adaptive loop of both models on the extended plant, and on machine.fmu if there is one."""
    plant = after.builder
    kinds = {
        "model": [Model(s.builder, base_parameters(s.builder.machine)) for s in (before, after)]
    }
    if truth_file(after.builder.machine_file).exists():
        kinds["machine"] = [before, after]
    loops = {}
    for kind, sides in kinds.items():
        say(f"closing the loop on the {kind}")
        with ThreadPoolExecutor(2) as pool:
            jobs = [pool.submit(_track, side, kind, plant, seconds) for side in sides]
            first, second = (job.result() for job in jobs)
            loops[kind] = first, second
    return loops


def _track(side: Model, kind: str, plant: Builder, seconds: float) -> Tracking:
    name = "plant" if kind == "model" else "machine"
    adaptive = table_cases(side.builder.machine, side.p, seconds, side.std)[-1]
    starts = dict(adaptive.starts)
    if name == "plant":
        starts.pop("plant", None)
    case = replace(adaptive, name=f"shown-{kind}", plant=name, starts=starts)
    signals = ("feedback.e", "feedback.tau_fb")
    result = run(side.builder.case(case, plant), case.duration, signals=signals, timing=False)
    judged = result.time("feedback.e") > SETTLE
    e, tau = result["feedback.e"][judged], result["feedback.tau_fb"][judged]
    return Tracking(rms(e) * MICRO, rms(tau))

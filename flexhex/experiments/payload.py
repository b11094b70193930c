"""Fig. 4 of the paper: the end-effector's mass changes in steps during the run.

The same trajectory twice: with the fitted parameters fixed, and with the parameters of the
end-effector adapting alone. The payload is a point mass at `c_payload` of E, so it changes
mass, first moment and inertia of E together; the mass is shown.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexhex.diagnosis.estimation.identify import Fit
from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import parameters
from flexhex.fmus.reference.interface import MAX_PAYLOADS
from flexhex.output.plots import COLOURS, LOG, Figure, figure, moving_rms, trace
from flexhex.output.progress import Progress
from flexhex.output.tables import Column
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import SETTLE, table_cases, whole_moves
from flexhex.simulation.metrics import rms
from flexhex.simulation.runs import Array, record, samples, variant, whole
from flexhex.ssp.results import Result

BODY, MASS = "end-effector", "end_effector.m"
COLUMNS = (
    Column("begin", "from", "s", ".1f"),
    Column("end", "to", "s", ".1f"),
    Column("true", "Δm true", "kg", ".2f"),
    Column("estimated", "Δm estimated", "kg", ".3f"),
    Column("fixed", "e fixed", "µrad", ".1f"),
    Column("adaptive", "e adaptive", "µrad", ".1f"),
    Column("fixed_settled", "e fixed, settled", "µrad", ".1f"),
    Column("adaptive_settled", "e adaptive, settled", "µrad", ".1f"),
)
STEPS = ((0.16, 0.25), (0.32, 0.5), (0.48, 1.0), (0.66, 0.5), (0.82, 0.0))
"""Share of the trajectory's time, mass [kg] from then on. Those of the paper are not printed."""
SIGNALS = ("feedback.e", "K.p", "K.p_std", "reference.payload", "plant.theta", "plant.tau_meas")


@dataclass(frozen=True)
class Payload:
    """Both runs: t (samples,) [s], e_fixed, e_adaptive (samples, n) [rad]; t_mass (m,) [s],
    mass, std, true (m,) [kg]: estimated change of mass, its deviation, the payload.
    times, masses: the schedule from time 0 on, [s] and [kg]. results: of both runs, fixed first.
    warm: whether the machine drifts, which the model does not."""

    t: Array
    e_fixed: Array
    e_adaptive: Array
    t_mass: Array
    mass: Array
    std: Array
    true: Array
    times: tuple[float, ...]
    masses: tuple[float, ...]
    results: tuple[Result, ...] = ()
    warm: bool = True


def mask(machine: Machine) -> Array:
    """1 for the parameters of the end-effector, 0 for all others (n_p,)."""
    chosen = np.array([float(par.body == BODY) for par in parameters(machine)])
    if not chosen.any():
        raise MachineError(
            f"machine {machine.name} has no end-effector whose mass could change:"
            " leave the experiment `payload` out, or describe a platform"
        )
    return chosen


def schedule(duration: float, base: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Times since the trajectory's begin [s] and masses [kg]; the first is no payload at 0."""
    times = tuple(whole(share * duration, base) for share, _ in STEPS)
    return (0.0, *times), (0.0, *(mass for _, mass in STEPS))


def _starts(times: tuple[float, ...], masses: tuple[float, ...]) -> dict[str, float | Array]:
    """The schedule as parameters of the reference, whose time includes the settling."""
    entries = np.zeros((2, MAX_PAYLOADS))
    entries[0, : len(times)], entries[1, : len(times)] = SETTLE + np.array(times), masses
    return {
        "payload_count": float(len(times)),
        "payload_time": entries[0],
        "payload_mass": entries[1],
    }


def run(builder: Builder, fit: Fit, progress: Progress, command: str, quick: bool) -> Payload:
    """The trajectory with changing mass, fixed and adaptive."""
    machine = builder.machine
    adapt = mask(machine)
    seconds = whole_moves(machine, 12.0) if quick else machine.reference.duration
    times, masses = schedule(seconds, machine.timing.base)
    reference = _starts(times, masses)
    _, fixed, adaptive = table_cases(machine, fit.p, seconds, fit.std)
    whole_time = fixed.duration
    cases = (
        variant(
            fixed, "payload-fixed", "mass changes, fixed", whole_time, {"reference": reference}
        ),
        variant(
            adaptive,
            "payload-adaptive",
            "mass changes, adaptive",
            whole_time,
            {"reference": reference, "K": {"adapt": adapt}},
        ),
    )
    results = record(builder, cases, SIGNALS, command, progress)
    payload = evaluate(machine, fit.p, results[0], results[1], (times, masses))
    return dataclasses.replace(payload, results=tuple(results), warm=builder.has_truth)


def evaluate(
    machine: Machine,
    p: Array,
    fixed: Result,
    adaptive: Result,
    steps: tuple[tuple[float, ...], tuple[float, ...]],
) -> Payload:
    """Errors of both runs, and the mass that the adaptive one estimates."""
    k = [par.name for par in parameters(machine)].index(MASS)
    t, e_fixed, _ = samples(fixed, "feedback.e")
    _, e_adaptive, _ = samples(adaptive, "feedback.e")
    t_mass, estimate, _ = samples(adaptive, "K.p")
    std = samples(adaptive, "K.p_std")[1][:, k]
    t_payload, payload, _ = samples(adaptive, "reference.payload")
    # the latest payload that each estimate can know of
    at = np.searchsorted(t_payload, t_mass + 1e-9, side="right") - 1
    mass = estimate[:, k] - p[k]
    return Payload(t, e_fixed, e_adaptive, t_mass, mass, std, payload[at], *steps)


def rows(result: Payload) -> list[dict[str, Any]]:
    """One row a stage: its time [s], true mass and mean estimate of its second half [kg], RMS
    error of both runs [urad], of the whole stage with its jump and of its second half."""
    ends = (*result.times[1:], float(result.t[-1]))
    listed = []
    for begin, end, mass in zip(result.times, ends, result.masses, strict=True):
        stage = (result.t >= begin) & (result.t < end)
        middle = (begin + end) / 2
        settled = stage & (result.t >= middle)
        late = (result.t_mass >= middle) & (result.t_mass < end)
        listed.append(
            {
                "begin": begin,
                "end": end,
                "true": mass,
                "estimated": float(result.mass[late].mean()),
                "fixed": 1e6 * rms(result.e_fixed[stage]),
                "adaptive": 1e6 * rms(result.e_adaptive[stage]),
                "fixed_settled": 1e6 * rms(result.e_fixed[settled]),
                "adaptive_settled": 1e6 * rms(result.e_adaptive[settled]),
            }
        )
    return listed


def figures(result: Payload) -> dict[str, Figure]:
    """The two halves of Fig. 4: error in a moving window, estimated and true change of mass."""
    return {"payload-error": _error(result), "payload-mass": _mass(result)}


def _error(result: Payload) -> Figure:
    ts = float(result.t[1] - result.t[0])
    lines = [
        trace(result.t, 1e6 * moving_rms(e, ts), name, COLOURS[name])
        for name, e in (("fixed", result.e_fixed), ("adaptive", result.e_adaptive))
    ]
    title = "Error while the mass changes, RMS over the joints in a 0.25 s window (as Fig. 4)"
    return figure(title, "time [s]", "e [µrad]", lines, yaxis=LOG, xaxis=_span(result))


def _mass(result: Payload) -> Figure:
    t, colour = result.t_mass, COLOURS["adaptive"]
    invisible = {"width": 0}
    high = trace(t, result.mass + result.std, "", showlegend=False, hoverinfo="skip")
    low = trace(t, result.mass - result.std, "± std", fill="tonexty", hoverinfo="skip")
    high["line"] = low["line"] = invisible
    low["fillcolor"] = "rgba(31, 111, 178, 0.18)"
    true = trace(t, result.true, "true", "#222", hoverinfo="y")
    true["line"] |= {"shape": "hv", "dash": "dash"}
    lines = [high, low, trace(t, result.mass, "estimated", colour), true]
    title, axis = "Change of the end-effector's mass", _span(result)
    return figure(title, "time [s]", "Δm [kg]", lines, xaxis=axis, height=300)


def _span(result: Payload) -> dict[str, Any]:
    """The same time axis for both plots."""
    return {"range": [0, round(float(result.t[-1]), 3)]}

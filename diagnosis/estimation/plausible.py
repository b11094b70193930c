"""Which logs and which fits of p are refused, and what a fit is warned of."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.rows import checked, long_enough
from flexhex.diagnosis.logs import Log
from flexhex.fmus.common.errors import LogError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.parameters import base_parameters, parameters, term

Array = NDArray[np.float64]
LEAST_EXPLAINED, WELL_EXPLAINED = 0.75, 0.95
"""Shares of the torque's RMS about its mean: with less the model is not of this machine, or is
doubtful."""
SCALED = 1.6
"""Ratio of fitted to nominal inertias that is worth a word."""
MASSIVE = (".m", ".J", ".J_xx", ".J_yy", ".J_zz")
"""Endings of masses and inertias; those of the regrouped lower arms may be negative."""
SURE = 4.0
"""Standard deviations by which a mass must be negative to be refused."""


def listed_names(machine: Machine) -> list[str]:
    """Names of p."""
    return [par.name for par in parameters(machine)]


def moving(machine: Machine, logs: Sequence[Log], settle: float) -> None:
    """LogError when a joint stands still, or two cannot be told apart."""
    spans = []
    for log in logs:
        checked(machine, log)
        long_enough(machine, log, settle)
        angle = log["theta"]
        used = angle.valid.copy()
        used[: int(settle / angle.ts)] = False
        if used.any():
            spans.append(np.ptp(angle.values[used], axis=0))
    if not spans:
        raise LogError(f"{logs[0].name}: nothing is left after {settle:.3g} s: too short")
    span, least = np.max(spans, axis=0), machine.actuator.sigma
    still = np.flatnonzero(span < least)
    if len(still):
        raise LogError(
            f"{logs[0].name}: theta[{still[0] + 1}] moves by {span[still[0]]:.3g} rad only,"
            f" {len(still)} of {len(span)} joints by less than {least:.3g} rad: use a trajectory"
            " that moves all joints"
        )


def plausible(machine: Machine, p: Array, std: Array, explained: float) -> tuple[str, ...]:
    """LogError for a negative mass or inertia, or a torque that the model does not explain."""
    names = listed_names(machine)
    massive = [n.partition("[")[0].endswith(MASSIVE) and not n.startswith("lower.") for n in names]
    positive = [term(n) in ("c", "d") or n.startswith("flexure.") for n in names]
    negative = p + SURE * std < 0
    bad = [n for n, heavy, less in zip(names, massive, negative, strict=True) if heavy and less]
    odd = [n for n, wanted, less in zip(names, positive, negative, strict=True) if wanted and less]
    if bad:
        turned = " Is the sign of the torque turned?" if len(bad) + len(odd) > 1 else ""
        raise LogError(
            f"the fit gives a negative {', '.join(bad[:4])}: the logs are not of {machine.name},"
            f" or a channel is wrong.{turned}"
        )
    if explained < LEAST_EXPLAINED:
        raise LogError(
            f"the model of {machine.name} explains only {max(explained, 0):.0%} of the torque:"
            " the logs are not of this machine, or channels are swapped"
        )
    warnings = [f"{', '.join(odd)}: negative, though no machine has it so"] if odd else []
    ratio = float(np.median(p[massive] / base_parameters(machine)[massive]))
    if not 1 / SCALED < ratio < SCALED:
        warnings.append(
            f"masses and inertias are {ratio:.2g} times those of {machine.name}: is the torque"
            " constant right?"
        )
    if explained < WELL_EXPLAINED:
        warnings.append(f"the model explains {explained:.0%} of the torque: is this its machine?")
    return tuple(warnings)

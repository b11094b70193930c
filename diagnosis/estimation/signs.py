"""Friction that no machine has, said as what it may come from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexhex.diagnosis.estimation.determined import SURE
from flexhex.diagnosis.estimation.estimate import Estimated
from flexhex.diagnosis.kinds import kinds_of
from flexhex.diagnosis.result.changed import NORMAL


def negative_friction(estimated: Estimated) -> tuple[list[str], set[str]]:
    """What the runs say of friction that they alone would have below zero, and its names."""
    findings, names = list[str](), set[str]()
    places = {known.name: place for place, known in enumerate(estimated.known)}
    for i, kind in enumerate(kinds_of(estimated.model.base, estimated.model.base.n)):
        own = [name for name in (f"d[{i + 1}]", f"F_c[{i + 1}]") if name in places]
        below = [name for name in own if _below(estimated, places[name])]
        if not below:
            continue
        names.update(below)
        values = " and ".join(_measured(estimated, places[name]) for name in own)
        if _driven(estimated, i, own):
            why = (
                f"it would drive the axis: its {kind.effort} or its {kind.position} has the other"
                " sign in the logs, or another axis' column. Negate one of the two columns, or name"
                " the right one"
            )
        elif below == [f"F_c[{i + 1}]"]:
            why = (
                f"the {kind.effort} is late against the {kind.position}, or friction grows faster"
                " than the rate, as drag does: `flexhex diagnose` searches for both"
            )
        else:
            why = (
                f"friction falls with the rate (`flexhex diagnose` knows Stribeck friction), or"
                f" {kind.effort} and {kind.position} are of other axes, signs or times: check the"
                " columns"
            )
        findings.append(
            f"friction of axis {i + 1} comes out negative, {values}, as of no machine, and is not"
            f" reported: {why}"
        )
    return findings, names


def _below(estimated: Estimated, place: int) -> bool:
    deviation = np.sqrt(max(float(estimated.covariance[place, place]), 0.0))
    return bool(estimated.free[place] < -SURE * deviation)


def _measured(estimated: Estimated, place: int) -> str:
    known, wide = estimated.known[place], NORMAL * np.sqrt(estimated.covariance[place, place])
    return f"{known.name} = {estimated.free[place]:.3g} ± {wide:.2g} {known.unit}"


def _driven(estimated: Estimated, axis: int, own: Sequence[str]) -> bool:
    """Whether friction as the runs alone have it feeds power into an axis."""
    power, names = 0.0, [known.name for known in estimated.known]
    rates = np.concatenate([b.run.motion.thetad[b.run.valid, axis] for b in estimated.model.blocks])
    for name in own:
        size = (rates**2).mean() if name.startswith("d") else np.abs(rates).mean()
        power += float(estimated.free[names.index(name)] * size)
    return power < 0

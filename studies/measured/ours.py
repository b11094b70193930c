"""What flexhex says of a set: parameters, errors, names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.estimation.inverse import inverse_model
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.prepare import Options
from flexhex.diagnosis.workflow import diagnose
from flexhex.fmus.inverse.equations import functions
from studies.measured.others import Rows
from studies.measured.sets import Measured

Array = NDArray[np.float64]


class Model:
    """The identified model as its FMU calculates, late by the delay that was found."""

    def __init__(self, result: Identified) -> None:
        self.result = result
        described = inverse_model(result)
        self.p = np.array([one.value for one in described.parameters])
        self.presliding, _, _, self.torque = functions(described)
        self.delay = result.delay.value

    def predicted(self, r: Rows) -> Array:
        """Torques (rows, n) of a filtered motion."""
        n = r.q.shape[1]
        z, before, play = np.zeros(n), r.q[0], []
        for q in r.q:
            z = self.presliding.call([q, before, z, self.p])[0].full().ravel()
            play.append(z)
            before = q
        many = self.torque.map(len(r.q))
        p, none = ca.repmat(ca.DM(self.p), 1, len(r.q)), np.zeros((1, len(r.q)))
        tau = many.call([r.q.T, r.v.T, r.a.T, np.array(play).T, none, p])[0].full().T
        at = r.t - self.delay
        return np.column_stack([np.interp(at, r.t, column) for column in tau.T])


def identified(measured: Measured, folder: Path) -> Model:
    """Fitted to the logs of a set, which are written into a folder."""
    fit, _ = measured.logs(folder)
    return Model(identify(fit, options=Options(measured.base)))


def payload(measured: Measured, folder: Path) -> dict[str, Any] | None:
    """The mass that was found on the loaded runs, whose heads say nothing of it."""
    fit, _ = measured.logs(folder)
    loaded = [measured.written(part, folder) for part in measured.loaded]
    fitted = identify([*fit, *loaded], options=Options(measured.base))
    mass = [one for one in fitted.parameters if one.name == "payload.m"]
    return mass[0].estimate.data() if mass else None


def named(measured: Measured, folder: Path) -> dict[str, Any]:
    """The diagnosis of its logs: verdict, names and axes, the residual on the test."""
    fit, test = measured.logs(folder)
    diagnosis = diagnose(fit, test, options=Options(measured.base))
    return {
        "verdict": diagnosis.verdict,
        "effects": [
            {
                "name": effect.id,
                "axes": list(effect.axes),
                "rivals": list(effect.rivals),
                "parameters": {n: e.data() for n, e in effect.parameters.items()},
            }
            for effect in diagnosis.effects
        ],
        "notes": list(diagnosis.notes),
        "residual": diagnosis.residual.data(),
    }

"""Parameters of a base model, friction beside it, fitted together to runs.

    q = argmin |y - B q|^2 / s^2 + |q|^2_prior,  bodies and friction as a machine can have them

Rows, noise, products between passes and delay are those of the diagnosis. s is what is left of the
rows: a model that leaves more than noise is trusted less beside what the file says.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.base import Base, Known
from flexhex.diagnosis.estimation import extras, friction
from flexhex.diagnosis.estimation.attenuation import taken_back
from flexhex.diagnosis.estimation.extras import Extras
from flexhex.diagnosis.estimation.friction import Form
from flexhex.diagnosis.estimation.machine_values import possible_values
from flexhex.diagnosis.estimation.uncertainty import covariance
from flexhex.diagnosis.estimation.weights import even, first_weights, levelled
from flexhex.diagnosis.jointfit.fit import held
from flexhex.diagnosis.jointfit.known import about_known
from flexhex.diagnosis.jointfit.leftover import axis_rms
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.regression import Columns, Regression
from flexhex.diagnosis.runs.blocks import blocks
from flexhex.diagnosis.runs.run import Run
from flexhex.diagnosis.runs.span import JUDGED, LATEST

Array = NDArray[np.float64]
ROUNDS, FORMED, LATER = 6, 2, 0.02
"""Fits at most; those of them that choose the form of friction; and the change of the delay and of
shapes, relative to tolerance and deviation, that ends them."""
FINER = (1.5, 1.5, 1.25, 1.25, 1.1)
"""Factors by which the numbers of a form are tried beside the best of the grid."""
APART = 0.5
"""Delay, in tolerances, beyond which none is tried too."""


@dataclass(frozen=True)
class Estimated:
    """A base model fitted to runs.

    `model.known` are its parameters, friction among them, `values` (nb,) their estimates in their
    units, `covariance` (nb, nb). free (nb,): the estimates before they had to be those of a
    machine; excess: what that adds to the sum of squares, in units of the noise; wrong: places of
    bodies and parameters, by name, that no machine has before. level: mean square of the rows,
    times as many as repeat each other. forms: dry friction of each axis. regression: of the rows,
    beside priors. extras: effects that a diagnosis found, fitted beside. attenuated (nb,): what
    noise of the angles had taken from the values, in which it is back.
    """

    model: Calibrated
    values: Array
    covariance: Array
    free: Array
    excess: float
    wrong: Mapping[str, tuple[int, ...]]
    level: float
    forms: tuple[Form, ...]
    regression: Regression
    extras: Extras
    attenuated: Array

    @property
    def known(self) -> tuple[Known, ...]:
        """The parameters."""
        return self.model.known

    @property
    def q(self) -> Array:
        """Coefficients of the rows (nb,)."""
        nominal = np.array([k.nominal for k in self.known])
        scale = self.model.scale
        times = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0)
        return np.asarray((self.values - nominal) * times)

    def along(self, runs: Sequence[Run]) -> Calibrated:
        """The same columns for other runs."""
        model, base = self.model, self.model.base
        theirs = blocks(base, runs, model.spacing, JUDGED)
        there = about_known(base, theirs, model.fitted, model.noise, model.blocks)
        own = [known for known in model.known if known.group in (friction.GROUP, extras.GROUP)]
        return _beside(there, own, self.forms, self.extras)


def estimate(base: Base, runs: Sequence[Run], more: Extras | None = None) -> tuple[Estimated, str]:
    """Fit a base model to runs; what was done about noise of the angles, or nothing."""
    more = more or Extras()
    model, _, done = fitted(base, runs)
    about = replace(model.fitted, losses=more.losses(base.n))
    model = about_known(model.base, model.blocks, about, first_weights(model))
    if base.n == 1 and more.lag > 0:
        # nothing would tell it from a delay of the logs
        model = held(model, 0.0, more.lag)
    return _estimated(model, more), done


def again(estimated: Estimated, base: Base) -> Estimated:
    """The same rows fitted by another base model with the same columns."""
    model = estimated.model
    other = about_known(base, model.blocks, model.fitted, model.noise)
    return _estimated(other, estimated.extras)


def _estimated(model: Calibrated, more: Extras) -> Estimated:
    """A base model with friction and further effects, from these weights on."""
    rubbing = more.beside(friction.parameters(model.base, model.blocks))
    dry = _dry(model, rubbing)
    estimated = _settled(model, rubbing, dry, more)
    if dry and abs(model.fitted.delay) > APART * model.fitted.late:
        # a wrong form of friction may be what is late
        prompt = about_known(
            model.base, model.blocks, replace(model.fitted, delay=0.0), model.noise
        )
        estimated = min(estimated, _settled(prompt, rubbing, dry, more), key=_left)
    return _finished(estimated)


@dataclass(frozen=True)
class _Fit:
    """A base model with friction and further effects, its regression beside priors, and the
    friction's forms."""

    model: Calibrated
    regression: Regression
    level: float
    forms: tuple[Form, ...]
    more: Extras

    @property
    def values(self) -> Array:
        """Of all parameters (nb,), in their units."""
        nominal = np.array([k.nominal for k in self.model.known])
        return np.asarray(nominal + self.model.scale * self.regression.q)


def _left(fit: _Fit) -> float:
    """Mean square of what is left, each axis relative to its torque."""
    left = axis_rms(fit.model.blocks, fit.model.residual(fit.regression.q))
    return float(((left / fit.model.torque_rms) ** 2).mean())


def _settled(
    model: Calibrated,
    rubbing: Sequence[Known],
    dry: dict[int, dict[Form, list[Array]]],
    more: Extras,
) -> _Fit:
    """Fits until the delay stays, from this one on."""
    usual = Form("rate", 1.0, "")
    forms = tuple(next(iter(dry.get(i, {usual: []}))) for i in range(model.base.n))
    for turn in range(ROUNDS):
        listed = [*rubbing, *more.parameters(model)] if more.listed else rubbing
        full = _beside(model, listed, forms, more)
        if turn < FORMED:
            forms = _formed(full, dry, forms)
            full = _beside(model, listed, forms, more)
        regression, level = levelled(full)
        fit = _Fit(full, regression, level, forms, more)
        values = dict(zip([k.name for k in full.known], fit.values.tolist(), strict=True))
        further = more.moved(model, values)
        effects = further.effects(model.base.n) if more.listed else []
        if effects:
            effects += friction.effects(rubbing, [values[k.name] for k in rubbing], forms)
        late = next(i for i, k in enumerate(full.known) if k.group == "delay")
        most = LATEST * model.fitted.late
        moved = replace(
            model.fitted,
            p=fit.values[: len(model.base.linear)],
            delay=float(np.clip(fit.values[late], -most, most)),
            loads={load.name: fit.values[full.places(load)] for load in full.loads},
            losses=further.losses(model.base.n),
            effects=tuple(effects),
        )
        settled = abs(moved.delay - model.fitted.delay) < LATER * model.fitted.late
        if settled and turn >= FORMED and further.apart(more) < LATER:
            break
        more = further
        model = about_known(model.base, model.blocks, moved, even(full, regression.q))
    return fit


def _beside(
    model: Calibrated, listed: Sequence[Known], forms: Sequence[Form], more: Extras
) -> Calibrated:
    """A base model with friction and further effects after its own parameters."""
    own = [k for k in listed if k.group == friction.GROUP]
    columns = friction.columns(model.blocks, own, forms)
    if more.listed:
        pairs = zip(columns, more.columns(model), strict=True)
        columns = [np.concatenate(both, axis=2) for both in pairs]
    return friction.beside(model, listed, columns)


def _dry(model: Calibrated, listed: Sequence[Known]) -> dict[int, dict[Form, list[Array]]]:
    """Smoothed dry friction of each axis that has it as a parameter, for all forms."""
    axes = [known.axis or 0 for known in listed if known.name.startswith("F_c")]
    return {
        axis: {
            form: [friction.dry(block, axis, form) for block in model.blocks]
            for form in friction.forms_of(model.base, model.blocks, axis)
        }
        for axis in axes
    }


def _formed(
    full: Calibrated, dry: dict[int, dict[Form, list[Array]]], forms: tuple[Form, ...]
) -> tuple[Form, ...]:
    """The form of each axis' dry friction that leaves least at this delay, beside the present ones
    of the other axes."""
    whole, best_forms = full.regression, list(forms)
    for axis, columns in dry.items():
        name = f"F_c[{axis + 1}]"
        others = np.array([k.name != name and k.group != "delay" for k in full.known])
        beside = whole.only(np.flatnonzero(others))

        def fall(form: Form, i: int = axis, rows: Regression = beside) -> float:
            known = dry[i].get(form)
            values = known or [friction.dry(block, i, form) for block in full.blocks]
            return rows.fall(Columns(i, full.white(i, values)))[0]

        best = max(columns, key=fall)
        for factor in FINER:
            best = max((best, *best.near(factor)), key=fall)
        best_forms[axis] = best
    return tuple(best_forms)


def _finished(fit: _Fit) -> Estimated:
    model, regression = fit.model, fit.regression
    back = model.scale * taken_back(model, regression)
    values = fit.values + back
    curvature = (np.diag(regression.prior) + regression.gram[0] + regression.firm) / fit.level
    result, wrong = possible_values(model, values, curvature)
    spread = covariance(model, regression, fit.level) * np.outer(
        model.scale, model.scale
    ) + np.outer(back, back)
    return Estimated(
        model, result.values, spread, values, result.excess, wrong, fit.level, fit.forms,
        regression, fit.more, back,
    )  # fmt: skip

"""The inverse dynamics that was identified, ready to be compiled: `flexhex.fmus.inverse`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca

from flexhex.diagnosis.basemodels.base import Base
from flexhex.diagnosis.basemodels.symbolic import symbolic_torque
from flexhex.diagnosis.estimation.extras import Extra, Extras
from flexhex.diagnosis.estimation.friction import GROUP
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.hypotheses.compiled import N_SIGNAL, signals
from flexhex.diagnosis.kinds import kinds_of, units_of
from flexhex.fmus.common.effects.own import OwnEffect
from flexhex.fmus.common.errors import MachineError, UsageError
from flexhex.fmus.inverse import equations
from flexhex.fmus.inverse.equations import Friction, Parameter

OTHERS = 16
"""Axes that a user's effect may ask for, when it is tried."""


def inverse_model(identified: Identified) -> equations.Identified:
    """The base model with its estimates, and friction in the form that was found.

    A payload of the logs and the delay of their torques are left out. UsageError for a fit with
    errors of geometry, MachineError for a base model that cannot be compiled.
    """
    estimated, base = identified.estimated, identified.estimated.model.base
    if base.geometry is not None:
        raise UsageError(
            "--fmu: places of joints or gravity were fitted, too, which the FMU takes from the"
            " file: take --tolerance geometry and gravity out"
        )
    values = {one.name: one.estimate.value for one in identified.parameters}
    own = [Parameter(k.name, k.printed, values[k.name]) for k in base.linear]
    rubbing = [k for k in estimated.known if k.group == GROUP]
    listed = [*own, *(Parameter(k.name, k.unit, values[k.name]) for k in rubbing)]
    frictions = []
    for i, form in enumerate(estimated.forms, start=1):
        there = {one.name: place for place, one in enumerate(listed[len(own) :], start=len(own))}
        dry, viscous, offset = (there.get(f"{name}[{i}]") for name in ("F_c", "d", "o"))
        rubs = Friction(dry, viscous, offset, "rate", None, None)
        if rubs.dry is not None:
            way = form.kind == "way"
            listed.append(Parameter(f"{'s_0' if way else 'v_s'}[{i}]", form.unit, form.size))
            rubs = replace(rubs, form="way" if way else "rate", size=len(listed) - 1)
            if form.lead:
                listed.append(Parameter(f"T_s[{i}]", "s", form.lead))
                rubs = replace(rubs, lead=len(listed) - 1)
        frictions.append(rubs)
    terms = tuple(_term(one, values, base, listed) for one in compiled_extras(estimated.extras))
    torque, size = symbolic_torque(base, f"--base {identified.base}"), len(own)
    return equations.Identified(
        units_of(base, base.n, "rad"),
        identified.units,
        lambda theta, thetad, thetadd, p: torque(theta, thetad, thetadd, p[:size]),
        tuple(listed),
        tuple(frictions),
        terms,
    )


def compiled_extras(extras: Extras) -> list[Extra]:
    """Those that an FMU can hold: what asks for the time of a run or for the rate of the torque is
    no feedforward of a wanted motion."""
    return [one for one in extras.listed if not _asks(one)]


def left_out(extras: Extras) -> list[str]:
    """Why it does not hold the others."""
    return [
        f"{one.effect.id} of axis {one.axis + 1} is not in the FMU: {_asks(one)}"
        for one in extras.listed
        if _asks(one)
    ]


def _asks(one: Extra) -> str:
    n, effect = one.axis + 1, one.effect
    if isinstance(effect, OwnEffect):
        try:
            effect.function(one.shape, OTHERS)
        except MachineError as error:
            return str(error)
        n = OTHERS
    u = ca.SX.sym("u", N_SIGNAL * (n + 1))
    state = ca.SX.sym("state", max(1, len(effect.states)))
    own = signals(n, u)
    then = effect.advance(own, own, state, dict(one.shape), ca.SX.sym("Ts"))
    depends = ca.which_depends(ca.vertcat(effect.columns(own, state, dict(one.shape)), then), u)
    rate, time = (any(depends[k::N_SIGNAL]) for k in (4, 5))
    if time:
        return "it drifts with the time of a run"
    return "it follows the rate of the torque" if rate else ""


def _term(
    one: Extra, values: Mapping[str, float], base: Base, listed: list[Parameter]
) -> equations.Term:
    """An effect, whose gains and shapes are listed."""
    kind = kinds_of(base, base.n)[one.axis]
    gains, shapes = [], {}
    for gain in one.effect.gains:
        name = one.parameter(gain.name)
        gains.append(len(listed))
        listed.append(Parameter(name, kind.unit(gain.unit), values[name]))
    for shape in one.effect.shapes:
        shapes[shape.name] = len(listed)
        name = one.parameter(shape.name)
        value = values.get(name, float(one.shape[shape.name]))
        listed.append(Parameter(name, kind.unit(shape.unit), value))
    return equations.Term(one.effect, one.axis, tuple(gains), shapes)

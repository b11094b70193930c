"""The inverse dynamics that was identified, ready to be compiled: `flexhex.fmus.inverse`."""

from __future__ import annotations

from dataclasses import replace

from flexhex.diagnosis.estimation.friction import GROUP
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.kinds import units_of
from flexhex.diagnosis.symbolic import symbolic_torque
from flexhex.fmus.common.errors import UsageError
from flexhex.fmus.inverse import equations
from flexhex.fmus.inverse.equations import Friction, Parameter


def inverse_model(found: Identified) -> equations.Identified:
    """The base model with its estimates, and friction in the form that was found.

    A payload of the logs and the delay of their torques are left out. UsageError for a fit with
    errors of geometry, MachineError for a base model that cannot be compiled.
    """
    estimated, base = found.estimated, found.estimated.made.base
    if base.geometry is not None:
        raise UsageError(
            "--fmu: places of joints were fitted, too, which the FMU takes from the file: take"
            " --tolerance geometry out"
        )
    values = {one.name: one.estimate.value for one in found.parameters}
    own = [Parameter(k.name, k.unit, values[k.name]) for k in base.linear]
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
    torque, size = symbolic_torque(base, f"--base {found.base}"), len(own)
    return equations.Identified(
        units_of(base, base.n, "rad"),
        found.units,
        lambda theta, thetad, thetadd, p: torque(theta, thetad, thetadd, p[:size]),
        tuple(listed),
        tuple(frictions),
    )

"""Torque and force constants of logs in amperes, or in volts that set a current."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexhex.diagnosis.kinds import ROTARY, Kinds
from flexhex.diagnosis.logs.log import Array, Finding, Options
from flexhex.diagnosis.logs.motor import Motor
from flexhex.diagnosis.logs.units import constants_shown, torque_constant
from flexhex.fmus.common.errors import LogError

Known = tuple[Kinds, Mapping[str, str], Options, Motor | None]
"""Kinds of the axes, metadata, options and motors of a log."""


def constants_of(
    where: str, channel: tuple[str, str], width: int, known: Known, findings: list[Finding]
) -> Array | None:
    """Torque or force constants (width,) [N m/A, N/A, or for V] from the options or the file;
    channel: its name and A or V. None where it is the voltage of a motor, known or not. LogError
    for constants of other axes or units, and without one of a current."""
    kinds, meta, options, motor = known
    name, base = channel
    wanted = (*kinds, *(ROTARY,) * width)[:width]
    given, of = options.torque_constant, wanted
    if base == "V" and motor is not None:
        return None
    if given is None and "torque_constant" in meta:
        given, of = torque_constant(where, meta["torque_constant"])
        if f"/{'A' if base == 'V' else 'V'}" in meta["torque_constant"]:
            raise LogError(
                f"{where}: {name} is in {base}, torque_constant is {meta['torque_constant']!r}:"
                " correct one of them"
            )
    if given is None and base == "V":
        return None
    if given is None:
        raise LogError(
            f"{where}: {name} is a current in A and no torque constant is known: write"
            f" `torque_constant: 3.0 {wanted[0].unit('N m')}/A` into the metadata or give"
            " --torque-constant (the machine file's drive.K_t, if it is the same drive)"
        )
    constants = np.atleast_1d(np.asarray(given, dtype=np.float64))
    if len(constants) not in (1, width):
        raise LogError(f"{where}: {len(constants)} torque constants for {width} axes")
    if any(mine is not own for mine, own in zip(of * width, wanted, strict=False)):
        units = ", ".join(f"{kind.unit('N m')}/{base}" for kind in wanted)
        raise LogError(
            f"{where}: torque_constant is {meta['torque_constant']!r}, wanted in {units}, axis by"
            " axis: theta says what each axis moves along"
        )
    shown = constants_shown(constants.tolist(), [f"{k.unit('N m')}/{base}" for k in wanted])
    text = f"{name} in {base} times the torque constant {shown}"
    findings.append(Finding("units", where, text, True))
    return np.broadcast_to(constants, (width,))

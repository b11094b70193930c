"""Torques of logs in volts: of motors that are known, or relative, in the volts themselves."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import replace
from itertools import pairwise

import numpy as np

from flexhex.diagnosis import stencils
from flexhex.diagnosis.kinds import IN_VOLTS, Kinds
from flexhex.diagnosis.logs.log import Array, Channel, Finding, Mask, Options
from flexhex.diagnosis.logs.motor import Motor, motor_of
from flexhex.diagnosis.logs.raw import Raw
from flexhex.fmus.common.errors import LogError

DRIVEN = ("current", "voltage")
"""Channels that stand for that of a torque."""
MEMORY = 7.0
"""Electrical time constants L/R after which a current has forgotten how it began: to 0.1 %."""


def motor_given(where: str, meta: Mapping[str, str], options: Options) -> Motor | None:
    """Data of the motors, of the options or else of the log's head; None without. LogError."""
    if options.motor is not None or options.torque_constant is not None or "motor" not in meta:
        return options.motor
    if "torque_constant" in meta:
        raise LogError(
            f"{where}: has both `motor` and `torque_constant` in its head: keep `motor` if its"
            " volts are those of the motor, `torque_constant` if they set a current"
        )
    try:
        return motor_of(meta["motor"])
    except ValueError as error:
        raise LogError(f"{where}: motor: {error}") from None


def without_voltage(raw: Raw) -> list[Finding]:
    """A file without voltages where it has torques or currents, and a finding that says so."""
    findings, names = list[Finding](), {name for table in raw.tables for name in table.values}
    for table in raw.tables:
        if "voltage" in table.values and (other := names & {"tau_meas", "current"}):
            del table.values["voltage"]
            text = f"voltage: not used, as there is {max(other)}"
            findings.append(Finding("extra", table.where, text, True))
    return findings


def with_motor(
    where: str,
    channels: dict[str, Channel],
    given: tuple[Motor | None, Set[str], Set[str]],
    kinds: Kinds,
) -> tuple[Kinds, list[Finding]]:
    """Torques in the place of voltages, and what is said of it; kinds of the axes: those in volts
    where nothing is known of the motors.

    given: motors, channels that are in V, and those of rates that are not used; kinds (n,).
    LogError for motors of other axes, or of a log whose torques are no voltages.
    """
    motor, volts, unused = given
    if motor is not None and "tau_meas" not in volts:
        raise LogError(
            f"{where}: motor data are for logs in V, but tau_meas is a torque, a force or a current"
            " here: take them out (a current in A takes a torque constant)"
        )
    findings = list[Finding]()
    for name in ("tau", "tau_ff"):
        # a part of a voltage makes no torque by itself
        apart = (name in volts) != ("tau_meas" in volts) or (motor and name == "tau_ff")
        if name in channels and apart:
            units = ("in V", "is not") if name in volts else ("not in V", "is")
            other = "feedforward of a motor" if motor else f"{units[0]}, as tau_meas {units[1]}"
            findings.append(Finding("units", where, f"{name}: {other}: not used", False))
            del channels[name]
    if "tau_meas" not in volts:
        return kinds, findings
    if motor is None:
        relative = tuple(IN_VOLTS[kind] for kind in kinds)
        return relative, [Finding("units", where, _relative(relative), False), *findings]
    if trouble := motor.trouble(kinds):
        raise LogError(f"{where}: motor: {trouble}")
    rate = None if "thetad" in unused else channels.get("thetad")
    for name in ("tau_meas", "tau"):
        if name in channels:
            channels[name] = torque_of(channels[name], channels["theta"], rate, motor)
    source = "differences of theta" if rate is None else "thetad"
    unit = " and ".join(dict.fromkeys(kind.unit("N m") for kind in kinds))
    text = f"tau_meas is {unit} by the motor data {motor.text} from V and rates, which are {source}"
    findings.append(Finding("units", where, text, True))
    if motor.doubt:
        findings.append(Finding("units", where, f"motor data: {motor.doubt}", False))
    return kinds, findings


def _relative(kinds: Kinds) -> str:
    inertia, rate = (
        " or ".join(dict.fromkeys(kind.unit(unit) for kind in kinds))
        for unit in ("kg m2", "N m s/rad")
    )
    return (
        "tau_meas is in V and no data of the motor are known: all results are relative, in volts"
        f" (friction and cogging V, inertia {inertia}, damping {rate}), and where these are the"
        " motor's volts viscous friction includes its back-EMF; --motor 'R=1.2 K_t=0.05', or"
        " --torque-constant of a current amplifier, makes them absolute"
    )


def torque_of(voltage: Channel, angle: Channel, rate: Channel | None, motor: Motor) -> Channel:
    """Torque or force (samples, n) [N m, N] of the axes from the logged voltages [V],

        L di/dt + R i = gain u - K_e gear thetad,    tau = gear K_t i,

    exact for voltages and rates that are straight lines between samples. rate: None takes
    differences of the angles.
    """
    n, rate = voltage.width, rate or _rates(angle)
    time, own = voltage.time, rate.time
    moved = np.column_stack([np.interp(time, own, column) for column in rate.values.T])
    valid = voltage.valid & (np.interp(time, own, rate.valid) > 0.999)
    valid &= (time >= own[0]) & (time <= own[-1])
    R, K_t, K_e, L, gear, gain = (
        motor.each(name, n) for name in ("R", "K_t", "K_e", "L", "gear", "gain")
    )
    current = (gain * voltage.values - K_e * gear * moved) / R
    memory = np.ceil(MEMORY * float((L / R).max()) / voltage.ts)
    for begin, end in pairwise(_edges(voltage)):
        for axis in np.flatnonzero(L):
            part = current[begin:end, axis]
            current[begin:end, axis] = _lagged(part, L[axis] / R[axis], voltage.ts)
        if memory and end > begin:
            valid[begin:end] = _remembers(valid[begin:end], memory)
    return replace(voltage, values=np.asarray(gear * K_t * current), valid=valid)


def _lagged(values: Array, lag: float, ts: float) -> Array:
    """The response (samples,) of lag dy/dt + y = value, straight between samples, settled at the
    first one."""
    from scipy.signal import lfilter  # takes long to load

    kept, ratio = np.exp(-ts / lag), lag / ts
    now, before = 1 - (1 - kept) * ratio, (1 - kept) * ratio - kept
    start = np.array([values[0] * (1 - now)])
    out, _ = lfilter([now, before], [1.0, -kept], values, zi=start)
    return np.asarray(out)


def _remembers(valid: Mask, memory: float) -> Mask:
    """Samples (samples,) whose current no longer knows of an invalid one, nor of the first."""
    index = np.arange(len(valid))
    last = np.maximum.accumulate(np.where(valid & (index > 0), -1, index))
    return np.asarray(valid & (index - last > memory))


def _rates(angle: Channel) -> Channel:
    """Rates (samples, n) by differences, none at the ends of a stretch."""
    values, valid, ends = np.zeros_like(angle.values), angle.valid.copy(), stencils.ENDS
    touched = np.convolve(~valid, np.ones(2 * ends + 1), "same") > 0.5
    for begin, end in pairwise(_edges(angle)):
        touched[begin : begin + ends] = touched[max(end - ends, begin) : end] = True
        if end - begin > 2 * ends:
            inner = stencils.first(angle.values[begin:end], angle.ts)
            values[begin:end] = np.pad(inner, ((ends, ends), (0, 0)), mode="edge")
    return replace(angle, values=values, valid=valid & ~touched)


def _edges(channel: Channel) -> list[int]:
    """Samples at which stretches without a break begin, and the end."""
    return [0, *(index for index, _ in channel.breaks), len(channel.values)]

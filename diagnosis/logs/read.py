"""Read a log: the reader for its kind, then units, clocks and values."""

from __future__ import annotations

import importlib
from dataclasses import replace
from pathlib import Path

import numpy as np

from flexhex.diagnosis.kinds import ROTARY, Kinds
from flexhex.diagnosis.logs.clock import Clock, clock_of
from flexhex.diagnosis.logs.clocks import compared
from flexhex.diagnosis.logs.constants import Known, constants_of
from flexhex.diagnosis.logs.delay import delays
from flexhex.diagnosis.logs.held import fresh
from flexhex.diagnosis.logs.log import Array, Channel, Finding, Log, Options
from flexhex.diagnosis.logs.rates import judged_rates
from flexhex.diagnosis.logs.raw import Raw, Table, no_log, texts, without_absurd
from flexhex.diagnosis.logs.renamed import Names, complete, unmatched
from flexhex.diagnosis.logs.stamps import stamped
from flexhex.diagnosis.logs.stated import chosen_units
from flexhex.diagnosis.logs.units import (
    SI,
    TORQUES,
    factor,
    is_current,
    is_voltage,
    kind_of,
)
from flexhex.diagnosis.logs.values import NEEDED, clipped, filled, judged, spikes
from flexhex.diagnosis.logs.voltage import DRIVEN, motor_given, with_motor, without_voltage
from flexhex.diagnosis.logs.wrapped import of_angles
from flexhex.fmus.common.errors import LogError, unreadable

READERS = {
    ".csv": ("csv", "read_csv"),
    ".txt": ("csv", "read_csv"),
    ".h5": ("hdf5", "read_hdf5"),
    ".hdf5": ("hdf5", "read_hdf5"),
    ".mat": ("mat", "read_mat"),
    ".parquet": ("extras", "read_parquet"),
    ".mf4": ("extras", "read_mdf"),
    ".mdf": ("extras", "read_mdf"),
    ".mcap": ("mcap", "read_mcap"),
    ".db3": ("db3", "read_db3"),
}


def read_log(path: str | Path, options: Options | None = None) -> Log:
    """Read one run; LogError tells file, channel and remedy for whatever is wrong."""
    path, options = Path(path), options or Options()
    names = Names(options.rename)
    if path.is_dir():
        within = sorted(file for file in path.iterdir() if file.suffix.lower() in READERS)
        hint = f", {within[0]}" if within else ""
        raise LogError(f"{unreadable(path, IsADirectoryError())}{hint}")
    if not path.is_file():
        raise LogError(unreadable(path, FileNotFoundError()))
    if path.suffix.lower() not in READERS:
        raise LogError(f"{path}: {no_log(path)}")
    module, function = READERS[path.suffix.lower()]
    reader = getattr(importlib.import_module(f"flexhex.diagnosis.logs.{module}"), function)
    try:
        raw: Raw = reader(path, replace(options, rename=names))
    except OSError as error:
        raise LogError(unreadable(path, error)) from None
    return _log_of(str(path), raw, options, names)


def _log_of(name: str, raw: Raw, options: Options, names: Names) -> Log:
    """A log of what was read; channels are taken from the tables one by one to save memory."""
    findings, meta = list(raw.findings), texts(name, raw.meta)
    channels: dict[str, Channel] = {}
    clocks: dict[str, Clock] = {}
    requests = list[str]()  # all at once, so that a user answers once
    kinds, volts = _kinds(raw, options), set[str]()
    motor, findings = motor_given(name, meta, options), [*findings, *without_voltage(raw)]
    known = kinds, meta, options, motor
    for table in raw.tables:
        if not table.values:
            continue
        findings += without_absurd(table)
        try:
            (unit,), told = chosen_units(table, "time", options.units)
            findings += [Finding("units", table.where, told, True)] if told else []
            scale, unknown = factor(table.where, "time", unit), ""
        except LogError as error:
            scale, unknown = 1.0, str(error)
            requests.append(unknown.removeprefix(f"{name}: "))
        time = table.time if scale == 1.0 else table.time * scale
        try:
            clock = stamped(
                table.where, clock_of(table.where, time, table.joins), time, table.values
            )
        except LogError as error:
            # of times in another unit whatever is said is nonsense
            raise LogError(unknown or str(error)) from None
        findings += clock.findings
        clocks[", ".join(table.values)] = clock
        for channel in list(table.values):
            if channel in channels:
                raise LogError(f"{table.where}: {channel} stands there twice: keep one of them")
            try:
                converted = _channel(table, channel, clock, (known, volts), findings)
            except LogError as error:
                requests.append(str(error).removeprefix(f"{name}: "))
                continue
            if converted is not None:
                channels["tau_meas" if channel in DRIVEN else channel] = converted
            del table.values[channel]
    if requests:
        raise LogError(f"{name}: {'; '.join(requests)}")
    complete(name, channels, [f.text for f in findings if f.kind == "extra"], names)
    findings += unmatched(name, names)
    if options.torque_constant is not None and not any(
        "torque constant" in str(f) for f in findings
    ):
        units = " and ".join(dict.fromkeys(kind.unit("N m") for kind in kinds))
        text = f"the torque constant that was given is not used: torques are in {units}"
        findings.append(Finding("units", name, text, True))
    findings += compared(name, clocks)
    unused, more = judged_rates(name, channels, kinds)
    known_as, said = with_motor(name, channels, (motor, volts, unused), kinds)
    findings = [*said, *findings, *judged(name, channels, kinds), *delays(name, channels), *more]
    return Log(name, channels, meta, tuple(findings), kinds=known_as, unused=unused)


def _kinds(raw: Raw, options: Options) -> Kinds:
    """What each axis moves along, by the units of its positions; () without such a channel."""
    for table in raw.tables:
        if "theta" in table.values:
            units, _ = chosen_units(table, "theta", options.units)
            return tuple(kind_of("theta", unit) or ROTARY for unit in units)
    return ()


def _channel(
    table: Table,
    name: str,
    clock: Clock,
    of_log: tuple[Known, set[str]],
    findings: list[Finding],
) -> Channel | None:
    """One channel in SI units on its clock, or None when it is left out with a finding.

    of_log: what is known of it, and where the names go of channels that stay in V.
    """
    known, volts = of_log
    kinds, _, options, _ = known
    where, values = table.where, table.values[name]
    units, told = chosen_units(table, name, options.units)
    findings += [Finding("units", where, told, True)] if told else []
    currents = [name in DRIVEN or is_current(name, unit) for unit in units]
    try:
        if any(currents) and not all(currents):
            raise LogError(f"{where}: {name} is a current on some axes only: make all of them one")
        if len(set(map(is_voltage, units))) > 1:
            raise LogError(f"{where}: {name} is in A on some axes, in V on others: make them one")
        of = "current" if any(currents) and name != "voltage" else name
        scale = np.array([factor(where, of, unit, k) for k, unit in enumerate(units, start=1)])
        _same_kind(where, name, units, kinds)
    except LogError as error:
        if name in (*NEEDED, *DRIVEN):
            raise
        findings.append(
            Finding("units", where, f"{error}; not used".removeprefix(f"{where}: "), False)
        )
        return None
    if any(currents):
        base = "V" if is_voltage(units[0]) else "A"
        constants = constants_of(where, (name, base), values.shape[1], known, findings)
        values *= scale if constants is None else scale * constants
    elif (scale != 1.0).any():
        values *= scale
        findings.append(Finding("units", where, _converted(name, units, scale, kinds), True))
    channel, more = filled(where, name, clock.channel(values))
    channel, held = fresh(where, name, channel)
    findings += [*more, *held]
    torque = name in TORQUES or any(currents)
    called = "tau_meas" if any(currents) else name
    for sound in of_angles(kinds) if name == "theta" else (spikes, clipped) if torque else ():
        channel, found = sound(where, called, channel)
        findings += found
    if any(currents) and constants is None:
        volts.add("tau_meas" if name in DRIVEN else name)
    if more and more[0].kind == "nan" and "no numbers" in more[0].text:
        return None
    return channel


def _same_kind(where: str, name: str, units: tuple[str, ...], kinds: Kinds) -> None:
    """LogError where a unit is not one of the axis' kind: a torque for a position in mm."""
    for k, (unit, kind) in enumerate(zip(units, kinds, strict=False), start=1):
        if kind_of(name, unit) not in (kind, None):
            raise LogError(
                f"{where}: {name}[{k}] is in {unit!r}, but theta[{k}] in a unit of a {kind.name}"
                f" axis, which wants {kind.unit(SI[name])!r} here: correct one of them in the file"
                f" or with --unit {name}=UNIT"
            )


def _converted(name: str, units: tuple[str, ...], scale: Array, kinds: Kinds) -> str:
    """What is said of a conversion: of the channel, or axis by axis where they differ."""
    listed = [kind.unit(SI[name]) for kind in (*kinds, *(ROTARY,) * len(units))]
    if len(set(units)) == 1:
        return f"{name} converted from {units[0]} to {listed[0]}"
    changed = [k for k in range(len(units)) if scale[k] != 1.0]
    return ", ".join(f"{name}[{k + 1}] converted from {units[k]} to {listed[k]}" for k in changed)

"""Read a log: the reader for its kind, then units, clocks and values."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np

from flexhex.diagnosis.logs.clock import Clock, clock_of
from flexhex.diagnosis.logs.clocks import compared
from flexhex.diagnosis.logs.delay import delays
from flexhex.diagnosis.logs.log import Channel, Finding, Log, Options
from flexhex.diagnosis.logs.raw import Raw, Table, texts
from flexhex.diagnosis.logs.stamps import stamped
from flexhex.diagnosis.logs.units import SI, TORQUES, factor, is_current, torque_constant
from flexhex.diagnosis.logs.values import clipped, filled, judged, jumps
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
}
NEEDED = ("theta", "tau_meas")


def read_log(path: str | Path, options: Options | None = None) -> Log:
    """Read one run; LogError tells file, channel and remedy for whatever is wrong."""
    path, options = Path(path), options or Options()
    if not path.is_file():
        missing = IsADirectoryError() if path.is_dir() else FileNotFoundError()
        raise LogError(unreadable(path, missing))
    if path.suffix.lower() not in READERS:
        raise LogError(
            f"{path}: unknown kind {path.suffix!r}; write CSV or HDF5 (.csv, .h5), or .mat,"
            " .parquet, .mf4"
        )
    module, function = READERS[path.suffix.lower()]
    reader = getattr(importlib.import_module(f"flexhex.diagnosis.logs.{module}"), function)
    try:
        raw: Raw = reader(path, options)
    except OSError as error:
        raise LogError(unreadable(path, error)) from None
    return _made(str(path), raw, options)


def _made(name: str, raw: Raw, options: Options) -> Log:
    """A log of what was read; channels are taken from the tables one by one to save memory."""
    findings, meta = list(raw.findings), texts(raw.meta)
    channels: dict[str, Channel] = {}
    clocks: dict[str, Clock] = {}
    for table in raw.tables:
        if not table.values:
            continue
        scale = factor(table.where, "time", options.units.get("time", table.unit))
        time = table.time if scale == 1.0 else table.time * scale
        clock = stamped(table.where, clock_of(table.where, time, table.joins), time, table.values)
        findings += clock.findings
        clocks[", ".join(table.values)] = clock
        for channel in list(table.values):
            if channel in channels:
                raise LogError(f"{table.where}: {channel} stands there twice: keep one of them")
            made = _channel(table, channel, clock, meta, options, findings)
            if made is not None:
                channels["tau_meas" if channel == "current" else channel] = made
            del table.values[channel]
    _complete(name, channels, [f.text for f in findings if f.kind == "extra"])
    if options.torque_constant is not None and not any(
        "torque constant" in str(f) for f in findings
    ):
        text = "the torque constant that was given is not used: torques are in N m"
        findings.append(Finding("units", name, text, True))
    findings += compared(name, clocks) + judged(name, channels) + delays(name, channels)
    return Log(name, channels, meta, tuple(findings))


def _channel(
    table: Table,
    name: str,
    clock: Clock,
    meta: dict[str, str],
    options: Options,
    findings: list[Finding],
) -> Channel | None:
    """One channel in SI units on its clock, or None when it is left out with a finding."""
    where, values = table.where, table.values[name]
    unit = options.units.get(name, table.units[name])
    current = name == "current" or is_current(name, unit)
    try:
        scale = factor(where, "current" if current else name, unit)
    except LogError as error:
        if name in (*NEEDED, "current"):
            raise
        findings.append(
            Finding("units", where, f"{error}; not used".removeprefix(f"{where}: "), False)
        )
        return None
    if current:
        values *= scale * _constants(where, name, values.shape[1], meta, options, findings)
    elif scale != 1.0:
        values *= scale
        findings.append(
            Finding("units", where, f"{name} converted from {unit} to {SI[name]}", True)
        )
    channel, more = filled(where, name, clock.channel(values))
    findings += more
    if name == "theta":
        channel, slips = jumps(where, channel)
        findings += slips
    if name in TORQUES or current:
        channel, more = clipped(where, "tau_meas" if current else name, channel)
        findings += more
    if more and more[0].kind == "nan" and "no numbers" in more[0].text:
        return None
    return channel


def _constants(
    where: str,
    name: str,
    width: int,
    meta: dict[str, str],
    options: Options,
    findings: list[Finding],
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Torque constants (width,) [N m/A] from the options or the file."""
    given = options.torque_constant
    if given is None and "torque_constant" in meta:
        given = torque_constant(where, meta["torque_constant"])
    if given is None:
        raise LogError(
            f"{where}: {name} is a current in A and no torque constant is known: write"
            " `torque_constant: 3.0 N m/A` into the metadata or give --torque-constant"
            " (the machine file's drive.K_t, if it is the same drive)"
        )
    constants = np.atleast_1d(np.asarray(given, dtype=np.float64))
    if len(constants) not in (1, width):
        raise LogError(f"{where}: {len(constants)} torque constants for {width} axes")
    shown = ", ".join(f"{k:.6g}" for k in constants)
    text = f"{name} in A times the torque constant {shown} N m/A"
    findings.append(Finding("units", where, text, True))
    return np.broadcast_to(constants, (width,))


def _complete(name: str, channels: dict[str, Channel], unused: list[str]) -> None:
    """LogError without angles or torques; unused: texts on the columns that are no channel."""
    has = "; ".join([f"it has {', '.join(channels) or 'none that is known'}", *unused])
    for needed in NEEDED:
        if needed not in channels:
            remedy = f"rename a column in the file or with --rename 'COLUMN={needed}[1]'"
            raise LogError(f"{name}: no channels {needed}[1], {needed}[2] ... ({has}): {remedy}")
    n, m = channels["theta"].width, channels["tau_meas"].width
    if n != m:
        raise LogError(f"{name}: {n} angles but {m} torques")

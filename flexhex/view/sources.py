"""What `view` and `plot` take: results, recordings of the gateway, logs given to the diagnosis."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexhex.compare.runs import Run, named_runs
from flexhex.diagnosis.kinds import kinds_of
from flexhex.diagnosis.logs import Log, Options, read_log
from flexhex.diagnosis.logs.units import SI
from flexhex.fmus.common.errors import LogError, unreadable
from flexhex.recording import load_run
from flexhex.ssp.result import Array, Group, Result, rate_name
from flexhex.view.shapes import Shape

THETA = ("plant.theta", "theta")
WANTED = ("reference.r", "r")
ERROR = ("feedback.e", "e")
PAYLOAD = ("reference.payload", "payload")
TORQUE = ("plant.tau_meas", "tau_meas", "feedback.tau", "tau")
RESIDUAL = ("residual",)
"""Where the parts of a motion stand, in results and in logs."""
DEFAULT = Options()


def load_sources(
    paths: list[Path], options: Options = DEFAULT, shape: Shape | None = None
) -> list[Run]:
    """Runs with names and colours. LogError for a file that is none, or for a log whose angles the
    machine cannot take."""
    return named_runs(paths, [load_source(path, options, shape) for path in paths])


def load_source(path: Path, options: Options = DEFAULT, shape: Shape | None = None) -> Result:
    """A result, a recording of the gateway, or a measured log as a result; options: how to read
    the last; shape: the machine that it has to be of."""
    if not path.is_file():
        raise LogError(
            unreadable(path, IsADirectoryError() if path.is_dir() else FileNotFoundError())
        )
    try:
        return load_run(path)
    except LogError as as_result:
        try:
            result = of_log(read_log(path, options))
        except LogError as as_log:
            reasons = [_reason(path, as_result), _reason(path, as_log)]
            if reasons[0] == reasons[1]:
                raise LogError(f"{path}: {reasons[0]}") from None
            raise LogError(
                f"{path}: shows no run: as a result: {reasons[0]}; as a measured log: {reasons[1]}"
            ) from None
    if shape is not None:
        refuse_far(path, result, shape)
    return result


def refuse_far(path: Path, result: Result, shape: Shape) -> None:
    """LogError for a log that is mostly beyond the stroke of the machine: it is another one's."""
    theta = np.abs(result[THETA[-1]].reshape(result.group(THETA[-1]).rows, -1))
    if theta.shape[1] == shape.width and float(np.median(theta.max(axis=1))) > shape.stroke:
        raise LogError(
            f"{path}: angles of up to {theta.max():.3g} rad, the stroke of {shape.data['name']} is"
            f" {shape.stroke:.3g} rad: say whose log it is, --base robot.urdf, or --base axis for"
            " axes without a model; or, where the file states another unit than its angles have,"
            " --unit 'theta=deg not rad'"
        )


def _reason(path: Path, error: LogError) -> str:
    return str(error).removeprefix(f"{path}: ")


def of_log(log: Log) -> Result:
    """A measured log as a result; time 0 is the first angle, pauses in the record are bridged."""
    begin, groups = log["theta"].time[0], dict[str, Group]()
    for name, channel in log.channels.items():
        values = _even(channel.time - begin, channel.values, channel.ts)
        samples = values if channel.width > 1 else values[:, 0]
        key = rate_name(1, channel.ts)
        old = groups.get(key, Group(1, channel.ts, {}))
        known = [part for part in old.signals.values() if len(part) != len(samples)]
        if known:
            key = f"{key} {name}"
            old = Group(1, channel.ts, {})
        axes = kinds_of(log, channel.width)
        unit = ",".join(kind.unit(SI.get(name, "")) for kind in axes)
        units = {**old.units, name: unit if len(set(axes)) > 1 else unit.partition(",")[0]}
        groups[key] = Group(1, channel.ts, {**old.signals, name: samples}, units)
    duration = max(group.rows * group.Ts for group in groups.values())
    return Result(groups, duration=duration, meta=dict(log.meta))


def _even(times: Array, values: Array, ts: float) -> Array:
    """Samples (n, width) at times [s] as samples at 0, ts, 2 ts ... (linear between them)."""
    wanted = np.arange(int(np.floor(times[-1] / ts + 1e-6)) + 1) * ts
    if len(wanted) == len(values) and np.allclose(wanted, times, atol=1e-3 * ts):
        return values
    return np.stack([np.interp(wanted, times, column) for column in values.T], axis=1)


def find(result: Result, names: tuple[str, ...]) -> str:
    """The first of the signals that a run has; empty for none."""
    return next((name for name in names if name in result), "")

"""Logs given to the diagnosis as runs: with the base model's torque and what it leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flexhex.compare.runs import Run, named_runs
from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.hypotheses.candidates import Bench
from flexhex.diagnosis.jointfit.elsewhere import elsewhere
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.kinds import refuse_others, units_of
from flexhex.diagnosis.logs import Log, read_log
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.runs.blocks import Block, blocks, torque_at
from flexhex.fmus.common.errors import LogError
from flexhex.ssp.result import Array, Group, Result
from flexhex.view.shapes import Shape, of_base
from flexhex.view.sources import of_log, refuse_far

TEXTS = {
    "tau_smooth": "measured, smoothed as the diagnosis does; dashed: the base model",
    "tau_model": "base model, fitted to these logs",
    "residual": "measured minus base model",
}
"""Signals that a fit adds."""


@dataclass(frozen=True)
class _Fit:
    """The base model fitted to some logs; rows of all logs with the torque that it leaves (m, n)
    [N m]."""

    model: Calibrated
    rows: tuple[tuple[Block, Array], ...]


def measured_runs(
    paths: Sequence[Path],
    machine_file: Path | None,
    options: Options,
    held_out: Sequence[Path] = (),
) -> tuple[list[Run], Shape, str]:
    """The logs as runs, what can be drawn of their machine, and what cannot be shown, or nothing.

    held_out: shown after the others, with the residual of a base model that was not fitted to them.
    Raises LogError, MachineError or UsageError for logs that are not of this base model.
    """
    every = [*paths, *held_out]
    logs = [read_log(path, options.log) for path in every]
    base = base_of(options.base, machine_file, logs[0], options.tolerance, options.joints)
    for log in logs:
        log.refuse_width(base.n)
        refuse_others(log.name, log.kinds, getattr(base, "kinds", ()), "the base model")
    shape = of_base(base, Path(options.base).name if machine_file is None else options.base)
    results, said = [of_log(log) for log in logs], shape.said
    for path, result in zip(every, results, strict=True):
        refuse_far(path, result, shape)
    try:
        fit = _fit(paths, held_out, machine_file, options)
        results = [_with(r, log, fit) for r, log in zip(results, logs, strict=True)]
    except LogError as error:
        said = f"No residual: {error}. {said}".strip()
    runs = named_runs(every, results)
    apart = [replace(run, name=f"{run.name} (held out)") for run in runs[len(paths) :]]
    return [*runs[: len(paths)], *apart], shape, said


def _fit(
    paths: Sequence[Path], held_out: Sequence[Path], machine_file: Path | None, options: Options
) -> _Fit:
    """The base model fitted to the logs, as the diagnosis begins, and held against the others."""
    base, request, trouble = run_set_of(paths, held_out, machine_file, options)
    if trouble:
        raise LogError(trouble)
    model, _, _ = fitted(base, request.runs)
    q = model.regression.q
    rows = list(zip(model.blocks, model.residual(q), strict=True))
    if request.judged:
        apart = blocks(model.base, request.judged, model.spacing)
        left = elsewhere(Bench(model, ()), apart, None).residual((), (), q)
        rows += zip(apart, left, strict=True)
    return _Fit(model, tuple(rows))


def _with(result: Result, log: Log, fit: _Fit) -> Result:
    """A log with the smoothed torque, that of the model and the residual; NaN where the fit has
    none."""
    model = fit.model
    begin, step = log["theta"].time[0], model.spacing
    count = int(np.floor((log["theta"].time[-1] - begin) / step)) + 1
    values = {name: np.full((count, model.base.n), np.nan) for name in TEXTS}
    for block, left in fit.rows:
        if block.run.name != log.name:
            continue
        torque = torque_at(block, model.base.window, model.fitted.delay)
        rows = np.rint((block.at + block.run.shift - begin) / step).astype(int)
        kept = block.usable & (rows >= 0) & (rows < count)
        for name, part in zip(TEXTS, (torque, torque - left, left), strict=True):
            values[name][rows[kept]] = part[kept]
    unit = ",".join(units_of(model.base, model.base.n, "N m"))
    signals = {name: v if model.base.n > 1 else v[:, 0] for name, v in values.items()}
    group = Group(1, step, signals, dict.fromkeys(TEXTS, unit), TEXTS)
    return replace(result, groups={**result.groups, "base model": group})

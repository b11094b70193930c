"""A drive whose iron saturates and whose report is late by more than a delay's tolerance, in noise
that hides that the delay is one until the saturation is found."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.workflow import Options, diagnose
from tests.diagnosis.single import SECONDS, TS, moved, wanted

Array = NDArray[np.float64]
CLOCK = np.arange(round(SECONDS / TS)) * TS
LATE, NOISE = 3, 0.1
"""Samples by which the report is late, where 2.5 are a delay's tolerance; white noise [N m]."""


def reported(torque: Array, saturates: float) -> Array:
    """What a drive reports (samples,) [N m] while the joint gets this: r (1 - s |r|) = tau."""
    root = np.sqrt(1 - 4 * saturates * np.abs(torque))
    return np.asarray(np.sign(torque) * (1 - root) / (2 * saturates))


def write(path: Path, motion: int, number: int, saturates: float, late: int) -> Path:
    """One pass in the tool's format."""
    rng = np.random.default_rng([motion, number])
    theta = moved(CLOCK, motion)[0] + 2e-6 * rng.standard_normal(len(CLOCK))
    tau = reported(wanted(CLOCK, motion), saturates)
    tau = np.concatenate([np.full(late, tau[0]), tau[: len(tau) - late]])
    tau += NOISE * rng.standard_normal(len(tau))
    rows = np.column_stack([CLOCK, 1e-6 * np.round(1e6 * theta), tau])
    head = f"# trajectory: {motion}\n# pass: {number}\ntime,theta[1],tau_meas[1]\ns,rad,N m"
    np.savetxt(path, rows, "%.7f", ",", header=head, comments="")
    return path


@pytest.mark.parametrize(("saturates", "late"), [(0.08, LATE), (0.04, LATE), (0.04, 0)])
def test_saturation_is_named_whatever_the_delay(
    saturates: float, late: int, tmp_path: Path
) -> None:
    """The fainter one in spite of its corner, which the runs do not determine."""
    runs = [(k, n) for k in (1, 2, 3) for n in (1, 2)]
    paths = [write(tmp_path / f"{k}_{n}.csv", k, n, saturates, late) for k, n in runs]
    found = diagnose(paths[:4], paths[4:], options=Options("axis"))
    assert [(e.id, e.axes) for e in found.effects] == [("torque_constant_saturation", (1,))]
    lags = [float(lag) for text in found.findings for lag in re.findall(r"by (\S+) ms", text)]
    assert lags == pytest.approx([late] if late else [], rel=0.05)

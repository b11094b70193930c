"""Diagnose each joint of a measured UR10e, moved alone: periods of one motion as its passes.

python examples/ur10e/diagnose.py DATASET      (its README tells where to get it)
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from flexhex.diagnosis.logs import Options as LogOptions
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose

Array = NDArray[np.float64]
GAINS = (14.87, 13.26, 11.13, 10.62, 11.03, 11.47)
"""Torque constants [N m/A] that the authors of the data found (their main.m)."""
PERIOD = 10.0
"""Of the motion [s]."""


def periods(log: Array, joint: int) -> list[tuple[int, int]]:
    """First sample and end of each period of a joint's log (samples, 31), from one upper reversal
    to the next; what is longer or shorter is none."""
    time, angle = log[:, 0], log[:, joint]
    apart = 0.7 * PERIOD * len(time) / np.ptp(time)
    peaks, _ = find_peaks(angle, angle.min() + 0.9 * np.ptp(angle), distance=apart)
    length = np.diff(time[peaks])
    return [p for p, s in zip(pairwise(peaks), length, strict=True) if abs(s / PERIOD - 1) < 0.01]


def passes(log: Array, joint: int, folder: Path) -> list[Path]:
    """One file for each period: runs of one trajectory."""
    passes_of = []
    for number, (begin, end) in enumerate(periods(log, joint), start=1):
        path = folder / f"joint{joint}-{number}.csv"
        rows = log[begin:end, [0, joint, 12 + joint]] - [log[begin, 0], 0, 0]
        head = f"# trajectory: sine\n# pass: {number}\ntime,theta,tau_meas\ns,rad,A"
        np.savetxt(path, rows, "%.4f", ",", header=head, comments="")
        passes_of.append(path)
    return passes_of


def reversals(log: Array, joint: int) -> list[tuple[float, float]]:
    """Half of the current's jump where the joint turns round, which is dry friction by no model,
    and the load there, the mean of the current's size before and after [A]; lower end first."""
    whole = periods(log, joint)
    part = log[whole[0][0] : whole[-1][1]]
    angle, current = part[:, joint], part[:, 12 + joint]
    rate = np.gradient(angle, part[:, 0])
    jumps = []
    for end in (angle.min(), angle.max()):
        near = np.abs(angle - end) < 5e-3 * np.ptp(angle)
        up, down = (
            float(current[near & (sign * rate > 0.03 * rate.max())].mean()) for sign in (1, -1)
        )
        jumps.append(((up - down) / 2, (abs(up) + abs(down)) / 2))
    return jumps


def line(joint: int, diagnosis: Diagnosis, ends: Sequence[tuple[float, float]]) -> str:
    """One row: what was named, dry friction of the model and of the bare data, the residual."""
    names = (
        ", ".join(" or ".join((effect.id, *effect.rivals)) for effect in diagnosis.effects) or "-"
    )
    values = {
        name: each for effect in diagnosis.effects for name, each in effect.parameters.items()
    }
    sizes = [
        f"{values[name].value:.3g} ± {np.ptp(values[name].ci95) / 2:.1g}{unit}"
        for name, unit in (("F_c", ""), ("mu", " |tau|"))
        if name in values
    ]
    jumps = ", ".join(f"{jump:.3g} at {load:.0f}" for jump, load in ends)
    before, after = (float(diagnosis.residual.held_out[name][0]) for name in ("before", "after"))
    residual = f"{before:.2f} to {after:.2f}"
    return f"{joint:5}  {' + '.join(sizes) or '-':34}  {jumps:23}  {residual:14}  {names}"


def main(arguments: Sequence[str] | None = None) -> int:
    """One row for each joint."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path, help="folder dataset_ur10e")
    dataset: Path = parser.parse_args(arguments).dataset
    files = [dataset / "jointwise_motion" / f"ur-20_01_22-joint_{k}.csv" for k in range(1, 7)]
    missing = [str(path) for path in files if not path.is_file()]
    if missing:
        print(f"{missing[0]}: no such file; examples/ur10e/README.md tells where from")
        return 3
    head = f"joint  {'friction [N m]':34}  {'jump/2 at load [N m]':23}  "
    print(f"{head}residual [N m]  what is missing")
    for joint, (path, gain) in enumerate(zip(files, GAINS, strict=True), start=1):
        log = np.loadtxt(path, delimiter=",")
        with tempfile.TemporaryDirectory() as folder:
            *runs, last = passes(log, joint, Path(folder))
            options = Options("axis", LogOptions(torque_constant=gain), 0)
            diagnosis = diagnose(runs, [last], options=options)
        ends = [(gain * jump, gain * load) for jump, load in reversals(log, joint)]
        print(line(joint, diagnosis, ends), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())

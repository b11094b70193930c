"""Measured runs as their authors publish them (three CSV files each) to logs, digit by digit.

    python examples/schunk/convert.py SOURCE TARGET

SOURCE holds folders measurement_<number>; TARGET gets run_<number>.csv.
"""

from __future__ import annotations

import sys
from pathlib import Path

AXES = 6
CHANNELS = (("theta", "rad"), ("thetad", "rad/s"), ("tau_meas", "N m"))


def converted(folder: Path) -> str:
    """One run as the text of a log: metadata, names, units, numbers as they stand."""
    files = [(folder / name).read_text().split() for name in ("time.csv", "trajectory.csv")]
    torque = (folder / "input.csv").read_text().split()
    names = ["time", *(f"{name}[{i + 1}]" for name, _ in CHANNELS for i in range(AXES))]
    units = ["s", *(unit for _, unit in CHANNELS for _ in range(AXES))]
    # the last instant has no torque: the run was over
    whole = zip(*(column[: len(torque)] for column in (*files, torque)), strict=True)
    rows = [",".join(row) for row in whole]
    head = [f"# run: {folder.name}", ",".join(names), ",".join(units)]
    return "\n".join([*head, *rows, ""])


def main(source: Path, target: Path) -> None:
    """Convert every run below `source`."""
    for folder in sorted(source.glob("measurement_*")):
        number = int(folder.name.removeprefix("measurement_"))
        (target / f"run_{number:03d}.csv").write_text(converted(folder))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))

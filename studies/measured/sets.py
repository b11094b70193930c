"""The sets: where their files lie below the data folder, what they hold, what is published."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

Array = NDArray[np.float64]
EMPS, UR10E, TX40 = "sysid-neural-continuous", "dynamic_calibration", "figaroh-examples"
"""Folders, as `git clone` names them."""
UR_GAINS = (14.87, 13.26, 11.13, 10.62, 11.03, 11.47)
"""Torque constants of the UR10e [N m/A] that its authors use."""
UR_FIT = (
    ("ur-20_02_10-30sec_12harm", 634, 3510),
    ("ur-20_02_12-40sec_12harm", 499, 4460),
    ("ur-20_02_05-20sec_8harm", 319, 2310),
)
UR_TEST = (("ur-20_01_17-ptp_10_points", 699, 4200),)
UR_LOADED = ("ur-20_02_19_14harm50secLoad", 0, None)
"""Files, and the rows of each in which the arm moves, as the authors have them."""
TX_RATIO = np.diag([32.0, 32.0, 45.0, -48.0, 45.0, 32.0])
"""Turns of the motors of the TX40 for one of its joints; joint 5 also turns motor 6."""
TX_RATIO[5, 4] = 32.0
TX_TURNED = np.array([0.0, -np.pi / 2, np.pi / 2, 0.0, 0.0, 0.0])
"""Angles [rad] of the model where the encoders of the TX40 say zero."""
TX_STEP, TX_FIT = 2e-4, 30_000
"""Sample time [s]; rows that are fitted, the others are tried on."""


@dataclass(frozen=True)
class Part:
    """A stretch of a log at even times: t (samples,) [s]; q, tau (samples, n) [rad, N m; m, N]."""

    name: str
    t: Array
    q: Array
    tau: Array

    @property
    def ts(self) -> float:
        """Sample time [s]."""
        return float((self.t[-1] - self.t[0]) / (len(self.t) - 1))


@dataclass(frozen=True)
class Measured:
    """A set: fit and test as arrays; base: what `--base` says; linear: whether its axis slides.

    cut [Hz]: corner of the filter that labs use on it. published: what is in print. loaded: runs
    with a payload, whose mass is `published["payload"]` [kg]. coupled: axes, from 0, that one motor
    turns together.
    """

    key: str
    title: str
    source: str
    licence: str
    base: str
    fit: Sequence[Part]
    test: Sequence[Part]
    cut: float
    linear: bool = False
    published: dict[str, float] = field(default_factory=dict)
    loaded: Sequence[Part] = ()
    coupled: tuple[int, int] | None = None

    def logs(self, folder: Path) -> tuple[list[Path], list[Path]]:
        """Its parts as CSV files in a folder: those of the fit, those of the test."""
        fit, test = ([self.written(p, folder) for p in parts] for parts in (self.fit, self.test))
        return fit, test

    def written(self, part: Part, folder: Path) -> Path:
        """A part as a CSV file in a folder."""
        n, path = part.q.shape[1], folder / f"{part.name}.csv"
        names = [f"{name}[{i + 1}]" for name in ("theta", "tau_meas") for i in range(n)]
        units = ["m" if self.linear else "rad"] * n + ["N" if self.linear else "N m"] * n
        head = f"# trajectory: {part.name}\ntime,{','.join(names)}\ns,{','.join(units)}"
        rows = np.column_stack([part.t, part.q, part.tau])
        np.savetxt(path, rows, "%.9g", ",", header=head, comments="")
        return path


def _even(count: int, step: float) -> Array:
    """So many times from 0 on [s]."""
    return np.asarray(np.arange(count) * step, dtype=np.float64)


def emps(data: Path) -> Measured:
    """One axis with a ball screw; a log of three passes, another with pulses of force."""
    folder = data / EMPS / "examples" / "EMPS" / "data"

    def part(name: str) -> Part:
        signals = {key: value.ravel() for key, value in loadmat(folder / f"{name}.mat").items()
                 if not key.startswith("_")}  # fmt: skip
        force = signals["gtau"][0] * signals["vir"]
        return Part(name, signals["t"], signals["qm"][:, None], force[:, None])

    return Measured(
        "emps",
        "EMPS, a linear axis",
        "A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, Workshop on"
        " Nonlinear System Identification Benchmarks, 2019",
        "none stated: for comparisons of methods",
        "axis",
        (part("DATA_EMPS"),),
        (part("DATA_EMPS_PULSES"),),
        40.0,
        True,
        {"m": 95.1089, "d": 203.5034, "F_c": 20.3935, "o": -3.1648, "error": 0.0408},
    )


def ur10e(data: Path) -> Measured:
    """Six joints; sums of sines, tried on a motion from point to point."""
    folder = data / UR10E
    where = folder / "dataset_ur10e"

    def part(name: str, first: int, end: int | None) -> Part:
        kind = "validation_data" if "ptp" in name else "identification_data"
        rows = np.loadtxt(where / kind / f"{name}.csv", delimiter=",")[first:end]
        t: Array = rows[:, 0] - rows[0, 0]
        even = _even(len(t), float(t[-1]) / (len(t) - 1))

        def at(columns: slice) -> Array:
            return np.column_stack([np.interp(even, t, c) for c in rows[:, columns].T])

        return Part(name, even, at(slice(1, 7)), at(slice(13, 19)) * UR_GAINS)

    return Measured(
        "ur10e",
        "UR10e, six joints",
        "S. Mamedov, S. Mikhel, Practical aspects of model-based collision detection, Frontiers in"
        " Robotics and AI 7, 2020",
        "none stated",
        str(folder / "URe" / "urdf" / "ur10e.urdf"),
        tuple(part(*one) for one in UR_FIT),
        tuple(part(*one) for one in UR_TEST),
        10.0,
        published={"payload": 2.805},
        loaded=(part(*UR_LOADED),),
    )


def tx40(data: Path) -> Measured:
    """Six joints of a Staubli arm, wrist coupled; the end of its only log is the test."""
    folder = data / TX40 / "examples" / "staubli_TX40"
    motors, current = (
        np.loadtxt(folder / "data" / f"{name}_data.csv", delimiter=",", skiprows=1)
        for name in ("pos_read", "curr")
    )
    q = motors @ np.linalg.inv(TX_RATIO).T + TX_TURNED
    tau, t = current @ TX_RATIO, _even(len(q), TX_STEP)
    fit, test = slice(0, TX_FIT), slice(TX_FIT, None)
    return Measured(
        "tx40",
        "Staubli TX40, six joints",
        "figaroh-examples, staubli_TX40",
        "Apache-2.0 in the files beside it",
        str(folder / "urdf" / "tx40_mdh_modified.urdf"),
        (Part("tx40-fit", t[fit], q[fit], tau[fit]),),
        (Part("tx40-test", t[test] - t[TX_FIT], q[test], tau[test]),),
        100.0,
        coupled=(4, 5),
    )


SETS: dict[str, tuple[str, Callable[[Path], Measured]]] = {
    "emps": (EMPS, emps),
    "ur10e": (UR10E, ur10e),
    "tx40": (TX40, tx40),
}

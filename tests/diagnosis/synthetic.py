"""Logs made up for the tests of reading: smooth motions, written in every kind of file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TS = 5e-4
UNITS = {"time": "s", "theta": "rad", "tau_meas": "N m", "r": "rad", "tau": "N m"}


def motion(seconds: float = 4.0, n: int = 2, seed: int = 0, ts: float = TS) -> dict[str, Array]:
    """time (samples,), theta and tau_meas (samples, n): sums of sines, torque with noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds / ts)) * ts
    w, phase, size = (rng.uniform(a, b, (4, n)) for a, b in ((1, 12), (0, 6.28), (0.02, 0.1)))
    waves = np.sin(w * t[:, None, None] + phase)
    theta = (size * waves).sum(axis=1)
    tau = ((size * w) * waves).sum(axis=1) + 0.01 * rng.standard_normal((len(t), n))
    return {"time": t, "theta": theta, "tau_meas": tau}


def columns(run: Mapping[str, Array]) -> tuple[list[str], list[str], Array]:
    """Names and units of the columns of a CSV log, and its numbers."""
    names, units, values = [], [], []
    for name, signal in run.items():
        if signal.ndim == 1:
            names, values = [*names, name], [*values, signal[:, None]]
            units.append(UNITS[name])
        else:
            names += [f"{name}[{k + 1}]" for k in range(signal.shape[1])]
            units += [UNITS[name]] * signal.shape[1]
            values.append(signal)
    return names, units, np.hstack(values)


def write_csv(
    path: Path,
    names: Sequence[str],
    units: Sequence[str] | None,
    values: Array,
    meta: Mapping[str, str] | None = None,
    separator: str = ",",
    point: str = ".",
    newline: str = "\n",
    bom: str = "",
) -> Path:
    """Numbers read back exactly; NaN is an empty field."""
    lines = [f"# {key}: {value}" for key, value in (meta or {}).items()]
    lines.append(separator.join(names))
    if units is not None:
        lines.append(separator.join(units))
    for row in values:
        fields = ["" if np.isnan(v) else repr(float(v)).replace(".", point) for v in row]
        lines.append(separator.join(fields))
    path.write_bytes((bom + newline.join(lines) + newline).encode())
    return path


def plain_csv(path: Path, run: Mapping[str, Array], **more: str) -> Path:
    """A CSV log as the convention has it; more: metadata."""
    return write_csv(path, *columns(run), meta=more)


def write_hdf5(path: Path, run: Mapping[str, Array], **meta: str) -> Path:
    """Datasets at the root with units, metadata as attributes."""
    with h5py.File(path, "w") as file:
        file.attrs.update(meta)
        for name, signal in run.items():
            file[name] = signal
            file[name].attrs["unit"] = UNITS[name]
    return path


def write_mat73(path: Path, run: Mapping[str, Array], **meta: str) -> Path:
    """As MATLAB's `save -v7.3` lays it out: transposed, texts as numbers of characters."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, signal in run.items():
            file[name] = np.atleast_2d(signal.T)
        for key, text in {**meta, **{f"{n}_unit": UNITS[n] for n in run}}.items():
            file[key] = np.array([[ord(c)] for c in text], dtype=np.uint16)
            file[key].attrs["MATLAB_class"] = np.bytes_("char")
    return path


def write_mat5(path: Path, run: Mapping[str, Array], **meta: str) -> Path:
    """MAT v5 with a struct `unit`."""
    from scipy.io import savemat

    savemat(path, {**run, **meta, "unit": {name: UNITS[name] for name in run}})
    return path

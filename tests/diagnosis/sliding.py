"""A mass on a guide as nature has it: inertia, damping, spring, what is hidden, noise.

Nothing of the house is used but the channel names of a log.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from tests.diagnosis.single import SECONDS, TS, lugre, moved

Array = NDArray[np.float64]
MASS, DAMPING, SPRING, OFFSET = 0.08, 0.3, 0.6, 0.05
NOISE, STEPS = 0.01, 1e-6
"""Of the force, and of the encoder."""
WAVE = 60.0
"""Order of the cogging."""
RUNS = ((1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2))
"""Motion and pass; the last motion is held out."""


def force(seed: int, friction: float, cogging: float) -> Array:
    """Force (samples,) that a motion takes."""
    t = np.arange(round(SECONDS / TS)) * TS
    x, rate, acceleration = moved(t, seed)
    rubbed = lugre(t, rate, friction) if friction else 0.0
    plain = MASS * acceleration + DAMPING * rate + SPRING * x + OFFSET
    return np.asarray(plain + rubbed + cogging * np.cos(WAVE * x))


def write(
    folder: Path,
    units: tuple[str, str],
    friction: Sequence[float] = (0.0,),
    cogging: Sequence[float] = (0.0,),
    written: tuple[float, float] = (1.0, 1.0),
) -> list[Path]:
    """Logs of a machine with an axis for each friction and cogging.

    units: of position and force, a text for all axes or one for each with commas between them;
    written: by which the numbers in the files are larger than the machine's.
    """
    folder.mkdir()
    paths = []
    t = np.arange(round(SECONDS / TS)) * TS
    pairs = list(zip(friction, cogging, strict=True))
    for seed, number in RUNS:
        rng = np.random.default_rng([seed, number])
        tau = np.stack([force(seed + 10 * k, *hidden) for k, hidden in enumerate(pairs)], axis=1)
        x = np.stack([moved(t, seed + 10 * k)[0] for k in range(len(pairs))], axis=1)
        read = np.round((x + 2 * STEPS * rng.standard_normal(x.shape)) / STEPS) * STEPS
        seen = tau + NOISE * rng.standard_normal(x.shape)
        path = folder / f"{seed}-{number}.h5"
        with h5py.File(path, "w") as file:
            file.attrs.update(trajectory=str(seed), **{"pass": str(number)})
            columns = ((t, "s"), (read * written[0], units[0]), (seen * written[1], units[1]))
            for name, (values, unit) in zip(("time", "theta", "tau_meas"), columns, strict=True):
                file[name] = values
                file[name].attrs["unit"] = unit
        paths.append(path)
    return paths

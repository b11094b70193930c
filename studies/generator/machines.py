"""Twenty machines, each with one to three hidden effects drawn from its seed, for the showcase.

Numbers 7 and 14 have an effect outside any list; it stands alone in the first and beside a
listed one in the second.
"""

from __future__ import annotations

import numpy as np

from studies.generator.draw import INSIDE, Case, assemble, place
from studies.generator.outside import OUTSIDE

COUNT = 20
FIRST_SEED = 2_000_000
STRANGE = {7: 1, 14: 2}
"""Machines with an effect outside the list, and how many effects these have in all."""


def machine(number: int, seconds: float = 12.0) -> Case:
    """Machine 1 to 20: effects, joints (one to three) and sizes (0.5 to 3 %) of its seed."""
    if not 1 <= number <= COUNT:
        raise ValueError(f"machine {number}: there are 1 to {COUNT}")
    seed = FIRST_SEED + number
    rng = np.random.default_rng([seed, 1])
    count = STRANGE.get(number, int(rng.integers(1, 4)))
    names = [str(name) for name in rng.choice(INSIDE, count, replace=False)]
    if number in STRANGE:
        names[0] = str(rng.choice([id for id in OUTSIDE if id != "mains_pickup"]))
    hidden = []
    for name in names:
        size = float(np.exp(rng.uniform(np.log(0.005), np.log(0.03))))
        hidden.append(place(rng, name, size, int(rng.integers(1, 4))))
    return assemble(seed, "machine", tuple(hidden), seconds)

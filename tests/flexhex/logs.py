"""Logs of two links with friction, as the commands take them."""

from __future__ import annotations

from pathlib import Path

from tests.diagnosis import two_links
from tests.diagnosis.estimation import machines
from tests.diagnosis.estimation.test_identified import FRICTION


def two_links_logs(folder: Path) -> list[str]:
    """Three of them, each along a motion of its own."""
    paths = list[str]()
    for seed in (1, 2, 3):
        run = two_links.run(seed, 1, 0.0, (0.0, 0.0))
        _, rate, _ = two_links.moved(run["time"], seed)
        tau = run["tau_meas"] + machines.rubbed(rate, FRICTION, (0.0, 0.0))
        head, path = f"# trajectory: {seed}\n", folder / f"{seed}.csv"
        machines.write(path, run["time"], run["theta"], tau, (False, False), head, seed)
        paths.append(str(path))
    return paths

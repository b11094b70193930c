"""An own motion over real frames: the gateway runs the .ssp of a trajectory as it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexhex.ssp.executor import run
from flexhex.trajectory.variant import with_trajectory
from tests.conftest import MACHINE_FILE, ROOT
from tests.gateway.bench import Bench
from tests.gateway.test_lockstep import SAME, same, simulated

BEGIN, SECONDS = 0.1, 10.0


def test_gateway_plays_poses_to_the_last_bit_of_the_simulation(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    example = ROOT / "examples" / "motion.csv"
    variant = with_trajectory(hexapod_ssp, example, MACHINE_FILE, tmp_path, begin=BEGIN)
    ran = Bench(variant.path, tmp_path).run(seconds=SECONDS)
    assert ran.code == 0, ran.words
    running = ran.table["phase"] == 1
    theirs = simulated(variant.path, 3.0 * 0.001)
    for name in SAME:
        # counts carry no sign of zero
        assert same(ran.table[name][running] + 0.0, theirs[name] + 0.0), name
    assert np.ptp(ran.table["theta"][running]) > 0.05, "nothing moved"
    assert not run(variant.path, SECONDS)["reference.fault"].any()

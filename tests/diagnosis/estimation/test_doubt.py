"""Logs that are not of the model as its file has it: that is said before all estimates."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.prepare import Options
from tests.diagnosis.estimation import machines


@pytest.mark.parametrize("off", [0.0, np.pi / 2])
def test_a_wrong_zero_of_an_angle_is_doubted(off: float, tmp_path: Path) -> None:
    """Centres and friction take up a good part of it, and nothing else would say so."""
    (tmp_path / "cart.xml").write_text(machines.CART)
    t, model, paths = np.arange(5000) * machines.TS, machines.heavier(machines.CART), []
    for seed in (1, 2):
        q, v, a = machines.moved(t, seed, (0.25, 0.7, 0.8))
        tau = machines.inverse(model, q, v, a) + machines.rubbed(v, machines.DRY, machines.VISCOUS)
        head, slides = f"# trajectory: {seed}\n", (True, False, False)
        read = q + np.array([0.0, off, 0.0])
        paths.append(machines.write(tmp_path / f"{seed}.csv", t, read, tau, slides, head, seed))
    identified = identify(paths, options=Options(str(tmp_path / "cart.xml")))
    assert identified.data()["doubt"] == identified.doubt
    assert ("with 90 degrees taken from the angle of axis 2" in identified.doubt) == (off > 0)
    assert bool(identified.doubt) == (off > 0)

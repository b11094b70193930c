"""Friction below zero is a finding with what may be wrong, and never a value."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.prepare import Options
from tests.diagnosis.estimation import machines


def axis(folder: Path, dry: float, viscous: float, sharp: float = 0.0) -> Identified:
    """An axis with such friction, and more of it the slower it goes."""
    t, paths = np.arange(5000) * machines.TS, []
    for seed in (1, 2):
        q, v, a = machines.moved(t, seed, (0.8,))
        tau = 0.4 * a + machines.rubbed(v, (dry,), (viscous,))
        tau += sharp * np.tanh(v / 0.02) * np.exp(-np.abs(v) / 0.5)
        path = folder / f"{seed}.csv"
        paths.append(machines.write(path, t, q, tau, (False,), f"# trajectory: {seed}\n", seed))
    return identify(paths, options=Options("axis"))


@pytest.mark.parametrize(("dry", "viscous", "sharp", "said"), [
    (-0.4, -0.6, 0.0, "its torque or its angle has the other sign in the logs"),
    (0.2, -0.6, 0.0, "its torque or its angle has the other sign in the logs"),
    (1.0, -0.2, 0.0, "friction falls with the rate (Stribeck friction)"),
    (-0.2, 1.0, 0.0, "friction grows faster than the rate, as drag does, or the torque lags"),
])  # fmt: skip
def test_negative_friction_is_said_with_what_may_be_wrong(
    dry: float, viscous: float, sharp: float, said: str, tmp_path: Path
) -> None:
    identified = axis(tmp_path, dry, viscous, sharp)
    finding = identified.findings[0]
    assert finding.startswith("axis 1 comes out with d[1] = ")
    assert said in finding
    assert finding.endswith("the nearest that a machine can have")
    for name, size in (("d[1]", viscous), ("F_c[1]", dry)):
        one = identified[name]
        assert one.estimate.value >= 0.0
        if size < 0:
            assert not one.determined, name
    assert not any("d[1]" in note or "F_c[1]" in note for note in identified.notes)


def test_friction_that_a_machine_has_is_no_finding(tmp_path: Path) -> None:
    identified = axis(tmp_path, 0.2, 0.1)
    assert not any("as no machine has it" in text for text in identified.findings)
    assert identified["d[1]"].determined
    assert identified["F_c[1]"].determined


def test_what_noise_leaves_well_above_zero_is_determined(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Damping of 0.8 N m s/rad, known to 0.26; dry friction of which nothing is known."""
    monkeypatch.setattr(machines, "NOISE", 0.5)
    t = 4 * machines.TS * np.arange(600)
    q, v, a = machines.moved(t, 1, (0.8,))
    path = machines.write(tmp_path / "1.csv", t, q, 0.4 * a + 0.8 * v, (False,), "", 3)
    identified = identify([path], options=Options("axis"))
    assert identified["d[1]"].determined
    assert not identified["F_c[1]"].determined

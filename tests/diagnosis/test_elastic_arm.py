"""An elastic joint behind a motor with friction, which makes the link swing: the friction does not
bend the gear, and what of it was fitted wrongly must not be taken for its torque."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexhex.diagnosis.hypotheses.signals import flat
from flexhex.diagnosis.prepare import Options
from flexhex.diagnosis.workflow import diagnose
from tests.diagnosis import elastic_arm
from tests.diagnosis.lwa4p import Link, write
from tests.diagnosis.synthetic import plain_csv

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")

COMPLIANCE = 1 / 12_000.0
"""Of the gear that gives way [rad/N m]."""
STIFF = 1e6


def diagnosed(
    folder: Path, stiffness: tuple[float, float]
) -> dict[str, dict[int, dict[str, tuple[float, float]]]]:
    """Intervals of the parameters of each named effect on each axis."""
    links = (
        Link((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 8.2, (0.198, 0.0, 0.0)),
        Link((elastic_arm.LENGTH, 0.0, 0.0), (0.0, 0.0, 0.0), 4.9, (0.181, 0.0, 0.0)),
    )
    pairs = enumerate(elastic_arm.ROTORS, 1)
    more = "".join(f"[rotor.joint_{k}]\ninertia = {J}\ntolerance = 0.1\n" for k, J in pairs)
    base = write(folder, links, (0.0, -elastic_arm.G, 0.0), "[tolerance]\ninertia = 0.3\n" + more)
    paths = []
    for motion, passes in ((1, 2), (2, 2), (3, 1)):
        for number in range(1, passes + 1):
            log = elastic_arm.run(motion, number, stiffness)
            heads = {"trajectory": str(motion), "pass": str(number)}
            paths.append(plain_csv(folder / f"{motion}{number}.csv", log, **heads))
    found = diagnose(paths[:4], paths[4:], None, Options(base=str(base)))
    return {
        effect.id: {axis: {n: v.ci95 for n, v in values.items()} for axis, values in effect.parts}
        for effect in found.effects
    }


@pytest.mark.sample(1, of="elastic joints beside friction")
@pytest.mark.parametrize(
    "stiffness", [(1 / COMPLIANCE, STIFF), (STIFF, STIFF)], ids=["soft", "stiff"]
)
def test_it_is_named_with_its_compliance_beside_friction(
    stiffness: tuple[float, float], tmp_path: Path
) -> None:
    named = diagnosed(tmp_path, stiffness)
    assert {*named.pop("coulomb_friction")} == {*named.pop("viscous_friction")} == {1, 2}
    assert {id: [*parts] for id, parts in named.items()} == (
        {"joint_elasticity": [1]} if stiffness[0] < STIFF else {}
    )
    for parts in named.values():
        low, high = parts[1]["c"]
        assert low <= COMPLIANCE <= high


def test_smoothing_keeps_slow_waves_where_and_as_large_as_they_are() -> None:
    clock = 1e-3 * np.arange(1000)
    wave = np.sin(2 * np.pi * 10.0 * clock)[:, None]
    smooth = flat(wave, 0.032, 1e-3)
    assert smooth.shape == wave.shape
    # under a Hann window alone 0.06 of it are gone
    assert smooth[100:-100] == pytest.approx(wave[100:-100], abs=5e-3)

"""A payload that an arm carries on some passes: mass and centre."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.diagnosis import two_links
from tests.diagnosis.lwa4p import Link, write
from tests.diagnosis.synthetic import plain_csv
from tests.diagnosis.test_payloads import answer, several, within

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")

LOAD, PLACE = 0.8, (0.31, 0.07)
"""A payload [kg], and where it is on the second link [m]."""


def arm_logs(folder: Path, said: str = "") -> list[Path]:
    """Two motions, four passes each, a payload on every other one; said: in those logs' heads."""
    paths = []
    for motion in (1, 2):
        for number in range(1, 5):
            heavy = number % 2 == 0
            run = two_links.run(motion, number, LOAD * heavy, PLACE)
            head = {"payload": said} if said and heavy else {}
            more = {"trajectory": str(motion), "pass": str(number), **head}
            paths.append(plain_csv(folder / f"{motion}{number}.csv", run, **more))
    return paths


@pytest.fixture
def planar(tmp_path: Path) -> str:
    """A base model whose masses are some percent off."""
    links = (
        Link((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 3.1, (0.175, 0.0, 0.0)),
        Link((two_links.L1, 0.0, 0.0), (0.0, 0.0, 0.0), 1.93, (0.153, 0.0, 0.0)),
    )
    vague = "[tolerance]\nmass = 0.1\ninertia = 0.5\ncentre = 0.05\n"
    return str(write(tmp_path, links, (0.0, -two_links.G, 0.0), vague))


@several
def test_payload_of_an_arm_has_mass_and_centre(planar: str, tmp_path: Path) -> None:
    diagnosis = answer(arm_logs(tmp_path), base=planar)
    assert not diagnosis.effects
    changed = {c.parameter: c for c in diagnosis.changed if c.parameter.startswith("payload")}
    assert within(changed["payload"], LOAD)
    assert within(changed["payload.c_x"], PLACE[0])
    assert within(changed["payload.c_y"], PLACE[1])
    assert [Path(run).stem for run in changed["payload"].runs] == ["12", "14", "22", "24"]


@several
@pytest.mark.parametrize("said", ["0.8", "0.824"], ids=["right", "3 % off"])
def test_announced_payload_of_an_arm_is_no_effect(said: str, planar: str, tmp_path: Path) -> None:
    diagnosis = answer(arm_logs(tmp_path, said), base=planar)
    assert not diagnosis.effects
    assert not [c for c in diagnosis.changed if c.parameter.startswith("payload")]

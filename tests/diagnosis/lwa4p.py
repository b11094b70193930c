"""The Schunk LWA 4P and arms like it: their table, written down apart from the example's file, and
the URDF that it makes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.logs import Log

Array = NDArray[np.float64]
Three = tuple[float, float, float]
FILE = Path(__file__).resolve().parents[2] / "examples" / "schunk" / "lwa4p.toml"
TS, THICK = 0.004, 0.05
"""Sample time [s]; radius of gyration of a link about its centre of mass [m]."""


@dataclass(frozen=True)
class Link:
    """at (3,) [m], rpy (3,) [rad]: its frame in the link before; it turns about its own z axis, or
    slides along it. centre (3,) [m] of its mass [kg], in its own frame; thick: radius of
    gyration about that [m]."""

    at: Three
    rpy: Three
    mass: float
    centre: Three
    slides: bool = False
    thick: float = THICK


ARM = (
    Link((0.0, 0.0, 0.11), (0.0, 0.0, 0.0), 1.7, (0.0, 0.0, 0.0)),
    Link((0.0, 0.0, 0.0), (pi / 2, 0.0, 0.0), 1.7, (0.0, 0.175, 0.0)),
    Link((0.0, 0.350, 0.0), (0.0, pi, 0.0), 2.1, (0.0, 0.0, 0.0)),
    Link((0.0, 0.0, 0.0), (-pi / 2, pi, 0.0), 1.7, (0.0, 0.0, 0.15)),
    Link((0.0, 0.005, 0.305), (pi / 2, 0.0, pi), 0.8, (0.0, 0.0, 0.0)),
    Link((0.0, 0.0, 0.0), (-pi / 2, 0.0, 0.0), 0.8, (0.0, 0.0, 0.04)),
)
GRAVITY = (0.3, -0.2, -9.81)


def urdf(links: Sequence[Link]) -> str:
    """A URDF of serial links link_1, link_2, ... on a foot."""
    text = ""
    for k, link in enumerate(links, start=1):
        J, kind = link.mass * link.thick**2, "prismatic" if link.slides else "continuous"
        limit = '<limit lower="-9" upper="9" effort="0" velocity="0"/>' if link.slides else ""
        text += (
            f'<link name="link_{k}"><inertial><origin xyz="{_three(link.centre)}"/>'
            f'<mass value="{link.mass}"/><inertia ixx="{J}" iyy="{J}" izz="{J}"'
            f' ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="joint_{k}" type="{kind}"><parent link="link_{k - 1}"/>'
            f'<child link="link_{k}"/><origin xyz="{_three(link.at)}" rpy="{_three(link.rpy)}"/>'
            f'<axis xyz="0 0 1"/>{limit}</joint>'
        )
    return f'<robot name="arm"><link name="link_0"/>{text}</robot>'


def _three(values: Three) -> str:
    return " ".join(repr(float(v)) for v in values)


def write(folder: Path, links: Sequence[Link], gravity: Three, more: str = "") -> Path:
    """The file beside their URDF; more: of the former."""
    (folder / "arm.urdf").write_text(urdf(links))
    file = folder / "arm.toml"
    file.write_text(f'robot = "arm.urdf"\ngravity = {list(gravity)}\n{more}')
    return file


def base_for(file: Path, axes: int = 6) -> RobotBase:
    base = base_of(str(file), None, Log.of("run.csv", TS, *np.zeros((2, 20, axes))))
    assert isinstance(base, RobotBase)
    return base

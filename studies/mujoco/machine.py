"""Serial machines: links, their MuJoCo model, and the file of them that the diagnosis gets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Three = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]
UNITS = {"hinge": ("rad", "N m"), "slide": ("m", "N")}
G = 9.81


@dataclass(frozen=True)
class Link:
    """A link that turns about, or slides along, its own z axis.

    at (3,) [m], rpy (3,) [rad]: its frame in that of the link before, about fixed x, then y, then
    z. mass [kg], centre (3,) [m], inertia (6,) [kg m2]: xx, yy, zz, xy, xz, yz about the centre of
    mass. armature [kg m2 or kg]: of the rotor, seen behind its gear.
    """

    at: Three
    rpy: Three
    mass: float
    centre: Three
    inertia: Six
    armature: float
    joint: str = "hinge"


@dataclass(frozen=True)
class Machine:
    """kind: axis, gantry, arm or hexapod. gravity (3,) [m/s2]; middle (n,): pose that it moves
    about; reach (n,): half of the stroke; frequency [Hz]: of its slowest motion. chain: the
    hexapod.Hexapod of a closed chain, which has no links."""

    kind: str
    links: tuple[Link, ...]
    gravity: Three
    middle: tuple[float, ...]
    reach: tuple[float, ...]
    frequency: float
    chain: Any = None

    @property
    def n(self) -> int:
        """Axes."""
        return len(self.middle)

    @property
    def units(self) -> tuple[str, str]:
        """Of position and torque."""
        return UNITS[self.links[0].joint if self.links else "hinge"]


@dataclass
class Parts:
    """What effects change in the MuJoCo model: attributes of joints and motors by axis (from 0),
    XML of bodies on links by axis, of tendons, of bodies beside the machine, and gravity."""

    joint: dict[int, dict[str, float]] = field(default_factory=dict)
    motor: dict[int, dict[str, str]] = field(default_factory=dict)
    bodies: dict[int, str] = field(default_factory=dict)
    tendons: str = ""
    world: str = ""
    gravity: Three | None = None


def mjcf(machine: Machine, step: float, parts: Parts) -> str:
    """XML of the MuJoCo model; joints j1.., motors in the order of the axes."""
    gravity = parts.gravity or machine.gravity
    inner = ""
    for k in reversed(range(machine.n)):
        inner = _body(machine.links[k], k, parts, inner, step)
    motors = "".join(_motor(k, parts.motor.get(k, {})) for k in range(machine.n))
    tendons = f"<tendon>{parts.tendons}</tendon>" if parts.tendons else ""
    return (
        '<mujoco><compiler angle="radian" autolimits="true"/>'
        f'<option timestep="{step:.12g}" gravity="{numbers(gravity)}" integrator="Euler"'
        ' iterations="50" tolerance="1e-12">'
        '<flag contact="disable" eulerdamp="disable"/></option>'
        f"<worldbody>{inner}{parts.world}</worldbody>{tendons}<actuator>{motors}</actuator></mujoco>"
    )


def _body(link: Link, k: int, parts: Parts, inner: str, step: float) -> str:
    settings = {"armature": link.armature, **parts.joint.get(k, {})}
    # dry friction acts within a few steps: MuJoCo's usual 20 ms make it a creep
    stiff = f'solreffriction="{max(4 * step, 1e-3):.6g} 1"'
    listed = " ".join(f'{name}="{value:.12g}"' for name, value in settings.items())
    return (
        f'<body name="b{k + 1}" pos="{numbers(link.at)}" quat="{numbers(quaternion(link.rpy))}">'
        f'<joint name="j{k + 1}" type="{link.joint}" axis="0 0 1" {stiff} {listed}/>'
        f"{inertial(link)}{parts.bodies.get(k, '')}{inner}</body>"
    )


def inertial(link: Link) -> str:
    """XML of mass, centre and inertia."""
    return (
        f'<inertial mass="{link.mass:.12g}" pos="{numbers(link.centre)}"'
        f' fullinertia="{numbers(link.inertia)}"/>'
    )


def _motor(k: int, settings: Mapping[str, str]) -> str:
    chosen = {"joint": f"j{k + 1}", "gainprm": "1", "biastype": "none", **settings}
    listed = "".join(f' {name}="{value}"' for name, value in chosen.items())
    return f'<general name="m{k + 1}"{listed}/>'


def numbers(values: Sequence[float] | Array) -> str:
    """Numbers as XML wants them."""
    return " ".join(f"{v:.15g}" for v in values)


def rotation(rpy: Three) -> Array:
    """Rotation (3, 3) about fixed x, then y, then z."""
    (sx, sy, sz), (cx, cy, cz) = np.sin(rpy), np.cos(rpy)
    X = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    Y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    Z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return np.asarray(Z @ Y @ X)


def quaternion(rpy: Three) -> Array:
    """The same as quaternion (4,), scalar first."""
    x, y, z = np.asarray(rpy) / 2
    (cx, sx), (cy, sy), (cz, sz) = ((np.cos(h), np.sin(h)) for h in (x, y, z))
    return np.array(
        [
            cx * cy * cz + sx * sy * sz,
            sx * cy * cz - cx * sy * sz,
            cx * sy * cz + sx * cy * sz,
            cx * cy * sz - sx * sy * cz,
        ]
    )


def full(inertia: Sequence[float]) -> Array:
    """Inertia (3, 3) of xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def six(J: Array) -> Six:
    """xx, yy, zz, xy, xz, yz of an inertia (3, 3)."""
    return (J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2])


def loaded(machine: Machine, mass: float, at: Three) -> Machine:
    """The machine with a point mass [kg] at `at` (3,) [m] of its last link."""
    if mass == 0.0:
        return machine
    last = machine.links[-1]
    total = last.mass + mass
    c, p = np.array(last.centre), np.array(at)
    middle = (last.mass * c + mass * p) / total
    J = full(last.inertia) + _moved(last.mass, c - middle) + _moved(mass, p - middle)
    heavier = replace(last, mass=total, centre=triple(middle), inertia=six(J))
    return replace(machine, links=(*machine.links[:-1], heavier))


def _moved(mass: float, d: Array) -> Array:
    return np.asarray(mass * (d @ d * np.eye(3) - np.outer(d, d)))


def triple(values: Array) -> Three:
    """Three floats."""
    x, y, z = (float(v) for v in values)
    return x, y, z


def mistaken(machine: Machine, mass: float, geometry: float, rng: np.random.Generator) -> Machine:
    """What the file says: masses, centres and inertias wrong by `mass`, frames by `geometry`
    (one standard deviation, relative; frames in units of the largest distance)."""
    size = max(max(float(np.linalg.norm(link.at)) for link in machine.links), 1e-3)

    def off(link: Link) -> Link:
        at = np.array(link.at) + geometry * size * rng.standard_normal(3)
        turn = np.array(link.rpy) + geometry * rng.standard_normal(3)
        reach = float(np.linalg.norm(link.centre))
        centre = np.array(link.centre) + mass * reach * rng.standard_normal(3)
        factor = float(np.exp(mass * rng.standard_normal()))
        return replace(
            link,
            at=triple(at),
            rpy=triple(turn),
            mass=link.mass * float(np.exp(mass * rng.standard_normal())),
            centre=triple(centre),
            inertia=six(full(link.inertia) * factor),
            armature=link.armature * float(np.exp(mass * rng.standard_normal())),
        )

    return replace(machine, links=tuple(off(link) for link in machine.links))


def toml(machine: Machine, mass: float, geometry: float) -> str:
    """The machine file: a table of links, with the tolerances of what it says."""
    length, force = machine.units
    head = [
        f'kind = "{machine.kind}"',
        f"gravity = {list(machine.gravity)} # m/s2",
        f'position_unit = "{length}"',
        f'torque_unit = "{force}"',
        f"tolerance_mass = {mass:.3g} # one standard deviation, relative",
        f"tolerance_geometry = {geometry:.3g} # relative",
    ]
    for link in machine.links:
        head += [
            "",
            "[[links]]",
            f'joint = "{link.joint}"',
            f"at = {_list(link.at)} # m, in the link before",
            f"rpy = {_list(link.rpy)} # rad, about fixed x, then y, then z; the axis is z",
            f"mass = {link.mass:.9g} # kg",
            f"centre = {_list(link.centre)} # m",
            f"inertia = {_list(link.inertia)} # kg m2: xx, yy, zz, xy, xz, yz about the centre",
            f"armature = {link.armature:.9g} # kg m2 or kg, behind the gear",
        ]
    return "\n".join([*head, ""])


def _list(values: Sequence[float]) -> str:
    return "[" + ", ".join(f"{v:.9g}" for v in values) + "]"

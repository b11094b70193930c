"""A closed-chain hexapod: six cranks, lower arms on universal joints with stiffness, connected to
a platform by MuJoCo's equality constraints; its machine file, and its inverse dynamics."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from studies.mujoco.machine import Array, Parts, full, numbers, six

TEMPLATE = Path(__file__).parents[2] / "machines" / "tflex.toml"
Rng = np.random.Generator


@dataclass(frozen=True)
class Body:
    """mass [kg], centre (3,) [m], inertia (6,) about it [kg m2]: xx, yy, zz, xy, xz, yz."""

    m: float
    c: Array
    Ic: Array


@dataclass(frozen=True)
class Hexapod:
    """L: length of the cranks; x_B, axis, u_B, r_EP (6, 3) and x_E0 (3,) as in the machine file;
    rotor: inertia of the motors [kg m2]; k_u (2,): of the universal joints; d: of the motors."""

    L: float
    x_E0: Array
    x_B: Array
    axis: Array
    u_B: Array
    r_EP: Array
    upper: Body
    lower: Body
    platform: Body
    rotor: float
    k_u: Array
    d: float
    spot: Array

    @property
    def rods(self) -> Array:
        """Lower arms (6, 3) in the world at neutral, from the cranks on."""
        return np.asarray(self.x_E0 + self.r_EP - self.x_B - self.L * self.u_B)


def drawn(rng: Rng) -> Hexapod:
    """The template's shape at another scale, with other bodies."""
    data = tomllib.loads(TEMPLATE.read_text(encoding="utf-8"))
    s = float(10 ** rng.uniform(-0.7, 0.4))
    weight = s**3 * float(rng.uniform(0.7, 1.4))

    def arms(name: str) -> Array:
        return np.array([arm[name]["value"] for arm in data["arms"]])

    def body(name: str) -> Body:
        row, m, c = data["bodies"][name], weight * rng.uniform(0.7, 1.4), s * rng.uniform(0.9, 1.1)
        return Body(
            float(row["m"]["value"] * m),
            np.array(row["c"]["value"]) * c,
            np.array(row["Ic"]["value"]) * m * c * c,
        )

    value = data["geometry"]
    return Hexapod(
        s * float(value["L"]["value"]),
        s * np.array(value["x_E0"]["value"]),
        s * arms("x_B"),
        arms("axis"),
        arms("u_B"),
        s * arms("r_EP"),
        body("upper"),
        body("lower"),
        body("end_effector"),
        float(data["bodies"]["upper"]["J_rotor"]["value"] * weight * s * s * rng.uniform(0.5, 3)),
        np.array(data["flexures"]["k_u"]["value"]) * weight * s * rng.uniform(0.2, 1.5),
        0.012 * weight * s**1.5,
        s * np.array(data["bodies"]["end_effector"]["c_payload"]["value"]),
    )


def mistaken(h: Hexapod, mass: float, geometry: float, rng: Rng) -> Hexapod:
    """What the file says: lengths of cranks and platform off by `geometry`, the rest by `mass`;
    lower arms are as long as closure wants them."""

    def off(b: Body) -> Body:
        m = float(np.exp(mass * rng.standard_normal()))
        c = b.c + mass * np.linalg.norm(b.c) * rng.standard_normal(3) * 0.3
        return Body(b.m * m, c, b.Ic * m)

    return replace(
        h,
        L=h.L * (1 + geometry * float(rng.standard_normal())),
        r_EP=h.r_EP * (1 + geometry * float(rng.standard_normal())),
        upper=off(h.upper),
        lower=off(h.lower),
        platform=off(h.platform),
        rotor=h.rotor * float(np.exp(mass * rng.standard_normal())),
        k_u=h.k_u * float(np.exp(mass * rng.standard_normal())),
    )


def loaded(h: Hexapod, mass: float) -> Hexapod:
    """With a point mass [kg] where payloads are bolted."""
    b, total = h.platform, h.platform.m + mass
    middle = (b.m * b.c + mass * h.spot) / total
    J = full(list(b.Ic))
    for m, p in ((b.m, b.c - middle), (mass, h.spot - middle)):
        J = J + m * (p @ p * np.eye(3) - np.outer(p, p))
    return replace(h, platform=Body(total, middle, np.array(six(J))))


def mjcf(h: Hexapod, gravity: Any, step: float, parts: Parts) -> str:
    """XML of the MuJoCo model: crank j1.., universal joints y1, z1.., platform last."""
    bodies, ties, motors = "", "", ""
    for k, rod in enumerate(h.rods):
        u, y = h.u_B[k], h.axis[k]
        B = np.column_stack([u, y, np.cross(u, y)])
        x = rod / np.linalg.norm(rod)
        side = y - (y @ x) * x
        side /= np.linalg.norm(side)
        Q = np.column_stack([x, side, np.cross(x, side)])
        own = {"armature": h.rotor, "damping": h.d}
        for name, value in parts.joint.get(k, {}).items():
            own[name] = own.get(name, 0.0) + value if name == "damping" else value
        listed = " ".join(f'{name}="{value:.12g}"' for name, value in own.items())
        stiff = f'solreffriction="{max(4 * step, 1e-3):.6g} 1"'
        bodies += (
            f'<body name="b{k + 1}" pos="{numbers(h.x_B[k])}" quat="{_quat(B)}">'
            f'<joint name="j{k + 1}" axis="0 1 0" {stiff} {listed}/>{_inertial(h.upper)}'
            f'<body name="l{k + 1}" pos="{h.L:.12g} 0 0" quat="{_quat(B.T @ Q)}">'
            f'<joint name="y{k + 1}" axis="0 1 0" stiffness="{h.k_u[0]:.12g}"/>'
            f'<joint name="z{k + 1}" axis="0 0 1" stiffness="{h.k_u[1]:.12g}"/>'
            f"{_inertial(h.lower)}"
            f'<site name="p{k + 1}" pos="{np.linalg.norm(rod):.15g} 0 0"/></body></body>'
        )
        ties += f'<connect site1="p{k + 1}" site2="e{k + 1}"/>'
        chosen = {"joint": f"j{k + 1}", "gainprm": "1", "biastype": "none"}
        chosen |= parts.motor.get(k, {})
        motors += "<general " + " ".join(f'{n}="{v}"' for n, v in chosen.items()) + "/>"
    sites = "".join(f'<site name="e{k + 1}" pos="{numbers(p)}"/>' for k, p in enumerate(h.r_EP))
    return (
        '<mujoco><compiler angle="radian" autolimits="true"/><default>'
        f'<equality solref="{2.5 * step:.9g} 1" solimp="0.9999 0.99999 0.001"/></default>'
        f'<option timestep="{step:.12g}" gravity="{numbers(parts.gravity or gravity)}"'
        ' integrator="Euler" iterations="50" tolerance="1e-12">'
        '<flag contact="disable" eulerdamp="disable"/></option>'
        f'<worldbody>{bodies}<body name="platform" pos="{numbers(h.x_E0)}"><freejoint/>'
        f"{_inertial(h.platform)}{sites}</body></worldbody>"
        f"<equality>{ties}</equality><actuator>{motors}</actuator></mujoco>"
    )


def _inertial(b: Body) -> str:
    return f'<inertial mass="{b.m:.12g}" pos="{numbers(b.c)}" fullinertia="{numbers(b.Ic)}"/>'


def _quat(R: Array) -> str:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, R.ravel())
    return numbers(quaternion)


def projections(model: mujoco.MjModel, q: Array, at: Array) -> Array:
    """Velocities of all joints (samples, n_v, 6) for unit rates of the cranks: the null space of
    the connections, on MuJoCo's own Jacobians."""
    data, nv = mujoco.MjData(model), model.nv
    rest = np.setdiff1d(np.arange(nv), at)
    projected, J = np.zeros((len(q), nv, len(at))), np.zeros((18, nv))
    one, two = np.zeros((2, 3, nv))
    for k in range(len(q)):
        data.qpos[:] = q[k]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        for i in range(model.neq):
            mujoco.mj_jacSite(model, data, one, None, model.eq_obj1id[i])
            mujoco.mj_jacSite(model, data, two, None, model.eq_obj2id[i])
            J[3 * i : 3 * i + 3] = one - two
        projected[k, at] = np.eye(len(at))
        projected[k, rest] = -np.linalg.solve(J[:, rest], J[:, at])
    return projected


def toml(h: Hexapod, reach: float, mass: float, geometry: float) -> str:
    """The machine file of base model `hexapod`: the template with this machine's values, and the
    tolerances of masses and geometry."""
    data = tomllib.loads(TEMPLATE.read_text(encoding="utf-8"))

    def put(section: dict[str, Any], name: str, value: Any) -> None:
        section[name]["value"] = value.tolist() if isinstance(value, np.ndarray) else value

    data["name"] = "hexapod"
    put(data["geometry"], "L", h.L)
    put(data["geometry"], "l", float(np.linalg.norm(h.rods[0])))
    put(data["geometry"], "x_E0", h.x_E0)
    put(data["geometry"], "stroke", min(1.5, 3 * reach))
    for k, arm in enumerate(data["arms"]):
        put(arm, "x_B", h.x_B[k])
        put(arm, "r_EP", h.r_EP[k])
    named = {"upper": h.upper, "lower": h.lower, "end_effector": h.platform}
    for name, body in named.items():
        for key, value in (("m", body.m), ("c", body.c), ("Ic", body.Ic)):
            put(data["bodies"][name], key, value)
    put(data["bodies"]["upper"], "J_rotor", h.rotor)
    put(data["bodies"]["end_effector"], "c_payload", h.spot)
    put(data["flexures"], "k_u", h.k_u)
    put(data["flexures"], "k_s", [0.0, 0.0])
    motor = data["actuator"]
    for name, one in (("o", 0.0), ("k", 0.0), ("d", h.d), ("c", 0.0)):
        put(motor, name, [one] * 6)
    for name in ("a", "b"):
        put(motor, name, [[0.0] * motor["n_harmonics"]] * 6)
    known = {"mass": mass, "inertia": mass, "geometry": geometry}
    data["tolerance"] = {
        name: {"value": float(f"{value:.3g}"), "unit": "1", "source": "assumed"}
        for name, value in known.items()
    }
    return _dumped(data)


def _dumped(data: dict[str, Any]) -> str:
    lines = [f'name = "{data.pop("name")}"', ""]
    for section, rows in data.items():
        for table in rows if isinstance(rows, list) else [rows]:
            lines.append(f"[[{section}]]" if isinstance(rows, list) else f"[{section}]")
            nested = [k for k, v in table.items() if isinstance(v, dict) and "value" not in v]
            lines += [f"{k} = {_plain(v)}" for k, v in table.items() if k not in nested]
            for name in nested:
                lines += ["", f"[{section}.{name}]"]
                lines += [f"{k} = {_plain(v)}" for k, v in table[name].items()]
            lines.append("")
    return "\n".join(lines)


def _plain(value: Any) -> str:
    if isinstance(value, dict):
        kept = {k: v for k, v in value.items() if k != "note"}
        return "{ " + ", ".join(f"{k} = {_plain(v)}" for k, v in kept.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(_plain(v) for v in value) + "]"
    return f'"{value}"' if isinstance(value, str) else repr(value)

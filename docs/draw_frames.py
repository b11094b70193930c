"""Draws docs/frames.svg from the machine file: `python docs/draw_frames.py`."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine

Array = NDArray[np.float64]
HERE = Path(__file__).resolve().parent
WIDTH, HEIGHT, SCALE = 760, 460, 760.0
TURN, TILT = math.radians(-62), math.radians(24)
"""From where one looks: about z, and down from the horizontal."""
ARM = 1
"""The arm that is drawn strongly (from 0)."""
ARROW = 0.11
"""Length of an axis [m]."""
BLUE, RED, GREEN, GREY, INK = "#1f6fb2", "#c0603a", "#3a8a4d", "#b8c0c8", "#222"


def place(point: Array) -> tuple[float, float]:
    """A point [m] on the paper [px]."""
    x, y, z = point
    u = math.cos(TURN) * x - math.sin(TURN) * y
    v = math.sin(TURN) * x + math.cos(TURN) * y
    return WIDTH * 0.47 + SCALE * u, HEIGHT * 0.78 - SCALE * (
        z * math.cos(TILT) + v * math.sin(TILT)
    )


def line(a: Array, b: Array, colour: str, width: float, more: str = "") -> str:
    """A straight line."""
    (x, y), (u, v) = place(a), place(b)
    return (
        f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{u:.1f}" y2="{v:.1f}" stroke="{colour}"'
        f' stroke-width="{width:g}" stroke-linecap="round" {more}/>'
    )


def arrow(a: Array, b: Array, colour: str) -> str:
    """A line with a tip."""
    return line(a, b, colour, 2, f'marker-end="url(#{colour[1:]})"')


def dot(at: Array, colour: str, size: float = 5) -> str:
    """A joint."""
    x, y = place(at)
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{size:g}" fill="{colour}" stroke="white"/>'


def label(at: Array, text: str, colour: str, dx: float = 8, dy: float = -8) -> str:
    """Words beside a point; `_` puts what follows below the line."""
    x, y = place(at)
    head, _, rest = text.partition("_")
    index, _, tail = rest.partition(" ")
    low = f'<tspan dy="4" font-size="75%">{index}</tspan><tspan dy="-4"> {tail}</tspan>'
    return (
        f'<text x="{x + dx:.1f}" y="{y + dy:.1f}" fill="{colour}" stroke="white" stroke-width="4"'
        f' paint-order="stroke">{head}{low if rest else ""}</text>'
    )


def loop(points: list[Array], fill: str, stroke: str) -> str:
    """A closed polygon."""
    corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(place, points))
    return f'<polygon points="{corners}" fill="{fill}" fill-opacity="0.6" stroke="{stroke}"/>'


def drawing(machine: Machine) -> str:
    """The mechanism at its neutral pose, one arm with its frames."""
    L, x_E = machine.geometry.L, np.array(machine.platform.x_E0)
    B = [np.array(arm.x_B) for arm in machine.arms]
    knee = [b + L * np.array(arm.u_B) for b, arm in zip(B, machine.arms, strict=True)]
    P = [x_E + np.array(r) for r in machine.platform.r_EP]
    zero, up = np.zeros(3), np.array([0.0, 0.0, ARROW])
    tips = "".join(
        f'<marker id="{c[1:]}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="6" markerHeight="6"'
        f' orient="auto"><path d="M0 0.5 8 4 0 7.5z" fill="{c}"/></marker>'
        for c in (BLUE, RED, GREEN, INK)
    )
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}"'
        f' height="{HEIGHT}" font-family="system-ui, sans-serif" font-size="15">',
        f"<title>frames and lengths of {machine.name}</title><defs>{tips}</defs>",
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        loop(B, "#eef1f4", GREY),
    ]
    for i in range(machine.n_arms):
        if i != ARM:
            parts += [line(B[i], knee[i], GREY, 5), line(knee[i], P[i], GREY, 3)]
            parts += [dot(p, GREY, 4) for p in (B[i], knee[i])]
    parts += [loop(P, "#dfe6ec", GREY)]
    arm, b, k, p = machine.arms[ARM], B[ARM], knee[ARM], P[ARM]
    axis, rod = np.array(arm.axis), (p - k) / np.linalg.norm(p - k)
    parts += [line(b, k, BLUE, 6), line(k, p, RED, 5)]
    parts += [arrow(zero, v, INK) for v in (up, [ARROW, 0, 0], [0, ARROW, 0])]
    parts += [arrow(x_E, x_E + v, GREEN) for v in (up, [ARROW, 0, 0], [0, ARROW, 0])]
    parts += [arrow(b, b + ARROW * axis, BLUE), arrow(b, b + ARROW * np.array(arm.u_B), BLUE)]
    parts += [arrow(k, k + ARROW * rod, RED)]
    parts += [line(zero, b, BLUE, 1.2, 'stroke-dasharray="5 4"')]
    parts += [line(x_E, p, GREEN, 1.2, 'stroke-dasharray="5 4"')]
    parts += [line(zero, x_E, INK, 1.2, 'stroke-dasharray="5 4"')]
    parts += [dot(zero, INK), dot(x_E, GREEN), dot(b, BLUE), dot(k, RED), dot(p, RED)]
    parts += [
        label(zero, "O", INK, -20, 4),
        label(zero + up, "z", INK, -16, 4),
        label(np.array([ARROW, 0, 0]), "x", INK, 3, -4),
        label(np.array([0, ARROW, 0]), "y", INK, 6, 2),
        label(x_E / 2, "x_E0", INK, -38, 0),
        label(x_E, "E", GREEN, -18, 14),
        label((x_E + p) / 2, "r_EP", GREEN, 4, 18),
        label(b / 2, "x_B", BLUE, 14, -4),
        label(b, "B", BLUE, 4, -10),
        label(b + ARROW * axis, "y of B: motor axis", BLUE, -136, 20),
        label(b + ARROW * np.array(arm.u_B), "u_B", BLUE, 6, -10),
        label((b + k) / 2, "upper arm, L", BLUE, -50, 38),
        label(k, "Q (universal joint)", RED, 6, 24),
        label((k + p) / 2, "lower arm, l", RED, 12, 4),
        label(p, "P (spherical joint)", RED, 10, -6),
    ]
    return "\n".join([*parts, "</svg>"]) + "\n"


if __name__ == "__main__":
    text = drawing(load_machine(HERE.parent / "machines" / "tflex.toml"))
    (HERE / "frames.svg").write_text(text, encoding="utf-8")

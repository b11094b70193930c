"""Draws docs/lengths.svg, the lengths that `flexhex init` takes: `python docs/draw_lengths.py`."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.init.hexapod import Hexapod

Array = NDArray[np.float64]
HERE = Path(__file__).resolve().parent
WIDTH, HEIGHT = 760, 410
ABOVE, ASIDE = (190.0, 185.0), (490.0, 310.0)
"""Where the centre stands in the view from above and from the side [px]."""
FINE, COARSE = 520.0, 390.0
"""Pixels of a metre from the side and from above."""
SHOWN = Hexapod(0.15, 0.16, 0.26, 0.06, 0.28, 0.2, 0.3)
"""The lengths that `init` begins with."""
BLUE, RED, GREEN, GREY = "#1f6fb2", "#c0603a", "#3a8a4d", "#b8c0c8"
Place = tuple[float, float]


def above(point: Array) -> Place:
    """A point [m] in the view from above [px]: the first pair of motors is to the right."""
    return ABOVE[0] + COARSE * point[0], ABOVE[1] - COARSE * point[1]


def aside(x: float, z: float) -> Place:
    """A point [m] of the plane through the centre and a pair of motors [px]."""
    return ASIDE[0] + FINE * x, ASIDE[1] - FINE * z


def line(a: Place, b: Place, colour: str, width: float, more: str = "") -> str:
    """A straight line."""
    return (
        f'<line x1="{a[0]:.1f}" y1="{a[1]:.1f}" x2="{b[0]:.1f}" y2="{b[1]:.1f}" stroke="{colour}"'
        f' stroke-width="{width:g}" stroke-linecap="round" {more}/>'
    )


def length(a: Place, b: Place, colour: str) -> str:
    """A line with a tip at both ends."""
    tips = f'marker-start="url(#{colour[1:]})" marker-end="url(#{colour[1:]})"'
    return line(a, b, colour, 1.8, tips)


def dot(at: Place, colour: str) -> str:
    """A joint."""
    return f'<circle cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="4.5" fill="{colour}" stroke="white"/>'


def label(at: Place, text: str, colour: str = "#222", anchor: str = "start") -> str:
    """Words that begin, end or have their middle at a point."""
    return (
        f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" fill="{colour}" text-anchor="{anchor}"'
        f' stroke="white" stroke-width="4" paint-order="stroke">{text}</text>'
    )


def polygon(points: list[Place], fill: str) -> str:
    """A plate."""
    corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polygon points="{corners}" fill="{fill}" fill-opacity="0.7" stroke="{GREY}"/>'


def from_above(hexapod: Hexapod) -> list[str]:
    """Motors, arms and platform; radius and spacing of both."""
    arms = hexapod.arms()
    motors, joints = [arm["x_B"] for arm in arms], [arm["r_EP"] for arm in arms]
    knees = [arm["x_B"] + hexapod.upper * arm["u_B"] for arm in arms]
    parts = [polygon([above(p) for p in motors], "#eef1f4")]
    # the platform's corners in the order in which they stand around the centre
    ring = sorted(joints, key=lambda p: math.atan2(p[1], p[0]))
    parts += [polygon([above(p) for p in ring], "#cfe3d4")]
    for motor, knee, joint in zip(motors, knees, joints, strict=True):
        parts += [
            line(above(motor), above(knee), GREY, 5),
            line(above(knee), above(joint), GREY, 2),
        ]
    parts += [dot(above(p), BLUE) for p in motors] + [dot(above(p), GREEN) for p in joints]
    zero, pair = np.zeros(3), (motors[0] + motors[1]) / 2
    # the second arm of the first pair and the first of the next share a pair of the platform
    middle = (joints[1] + joints[2]) / 2
    out = 0.04 * middle / np.linalg.norm(middle)
    parts += [
        length(above(zero), above(pair), BLUE),
        length(above(motors[0]), above(motors[1]), BLUE),
    ]
    parts += [length(above(zero), above(middle), GREEN)]
    parts += [length(above(joints[1] + out), above(joints[2] + out), GREEN)]
    x, y = above(pair)
    u, v = above(middle)
    return [
        *parts,
        label((above(zero)[0] + 8, y + 18), "radius", BLUE),
        label((x + 8, y + 5), "spacing", BLUE),
        label(((above(zero)[0] + u) / 2 - 12, (y + v) / 2 - 4), "platform-radius", GREEN, "end"),
        label((u + 24, v - 14), "platform-spacing", GREEN),
        label((ABOVE[0], HEIGHT - 12), "from above", anchor="middle"),
    ]


def from_the_side(hexapod: Hexapod) -> list[str]:
    """Upper arm, lift, height; the lower arm follows."""
    radius, z = hexapod.radius, hexapod.height
    knee = (
        radius + hexapod.upper * math.cos(hexapod.lift),
        hexapod.upper * math.sin(hexapod.lift),
    )
    reach = hexapod.platform_radius * math.cos(math.pi / 3)
    centre, motor, tip = aside(0, 0), aside(radius, 0), aside(*knee)
    end, joint = aside(0, z), aside(reach, z)
    level = aside(knee[0], 0)
    bow = 0.17 * FINE
    turned = (motor[0] + bow * math.cos(hexapod.lift), motor[1] - bow * math.sin(hexapod.lift))
    return [
        line(aside(-0.05, 0), aside(knee[0] + 0.03, 0), GREY, 1, 'stroke-dasharray="5 4"'),
        line(end, joint, GREEN, 5),
        line(tip, joint, GREY, 3),
        line(motor, tip, RED, 6),
        f'<path d="M{motor[0] + bow:.1f} {motor[1]:.1f} A{bow:.1f} {bow:.1f} 0 0 0'
        f' {turned[0]:.1f} {turned[1]:.1f}" fill="none" stroke="{RED}" stroke-width="1.8"/>',
        length(centre, end, GREEN),
        length((centre[0], centre[1] + 22), (motor[0], motor[1] + 22), BLUE),
        *(dot(at, colour) for at, colour in ((motor, BLUE), (tip, RED), (joint, GREEN))),
        label((centre[0] + 8, (centre[1] + end[1]) / 2), "height", GREEN),
        label(((centre[0] + motor[0]) / 2, centre[1] + 42), "radius", BLUE, "middle"),
        label(((motor[0] + tip[0]) / 2 - 12, (motor[1] + tip[1]) / 2 - 14), "upper", RED, "end"),
        label((motor[0] + bow + 8, motor[1] - 5), "lift", RED),
        label(((tip[0] + joint[0]) / 2 + 12, (tip[1] + joint[1]) / 2), "follows", "#777"),
        label((level[0] / 2 + centre[0] / 2, HEIGHT - 12), "from the side", anchor="middle"),
    ]


def drawing(hexapod: Hexapod = SHOWN) -> str:
    """Both views as SVG."""
    tips = "".join(
        f'<marker id="{c[1:]}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="6" markerHeight="6"'
        f' orient="auto-start-reverse"><path d="M0 0.5 8 4 0 7.5z" fill="{c}"/></marker>'
        for c in (BLUE, GREEN)
    )
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}"'
        f' height="{HEIGHT}" font-family="system-ui, sans-serif" font-size="15">',
        f"<title>lengths of a hexapod of three pairs of arms</title><defs>{tips}</defs>",
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        *from_above(hexapod),
        *from_the_side(hexapod),
    ]
    return "\n".join([*parts, "</svg>"]) + "\n"


if __name__ == "__main__":
    (HERE / "lengths.svg").write_text(drawing(), encoding="utf-8")

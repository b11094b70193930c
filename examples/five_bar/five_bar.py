"""A planar five-bar in a vertical plane, a closed chain as base model of your own:

flexhex identify RUN... --base examples/five_bar/five_bar.py:FiveBar

Two motors at A1 and A2 turn arms of length ARM, at whose ends rods of length ROD meet in P. Angles
from the horizontal; the elbows are outside, P above.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FOOT, ARM, ROD, GRAVITY = 0.1, 0.25, 0.4, 9.81  # half the distance of the motors, lengths [m]
DENSE = 1.2  # mass of a metre of each bar [kg/m]


def _bar(name: str, length: float, moved: bool) -> list[tuple[str, str, float, float]]:
    """Mass, first moment and moment of inertia of a bar about its first joint, each 10 % unsure; of
    a bar on a fixed joint the mass is not felt."""
    m = DENSE * length
    three = [("m", "kg", m), ("mc", "kg m", m * length / 2), ("J", "kg m2", m * length**2 / 3)]
    return [(f"{name}.{n}", unit, v, 0.1 * v) for n, unit, v in three[0 if moved else 1 :]]


class FiveBar:
    axes = ("rotary", "rotary")
    parameters = (
        *_bar("arm_1", ARM, False),
        *_bar("arm_2", ARM, False),
        *_bar("rod_1", ROD, True),
        *_bar("rod_2", ROD, True),
    )

    def bars(self, theta: Array) -> Array:
        """Ends of arm 1, arm 2, rod 1, rod 2 in the plane x, z, for `flexhex view`,
        (samples, 4, 2, 3) [m]."""
        (c1, c2), (s1, s2) = np.cos(theta).T, np.sin(theta).T
        zero = np.zeros_like(c1)
        elbows = (ARM * c1 - FOOT, ARM * s1), (ARM * c2 + FOOT, ARM * s2)
        feet, tip = ((zero - FOOT, zero), (zero + FOOT, zero)), _meet(*elbows)
        ends = [*zip(feet, elbows, strict=True), *((elbow, tip) for elbow in elbows)]
        placed = [[np.stack([x, zero, z], axis=1) for x, z in pair] for pair in ends]
        return np.moveaxis(np.array(placed), 2, 0)

    def columns(self, theta: Array, thetad: Array, thetadd: Array) -> Array:
        """Torques of both motors for one of each parameter, (samples, 2, 10).

        By virtual power: a mass at r wants m (r'' + g), of motor j its part along dr/dq_j.
        A point of a bar is B + s e; its integrals over s are m, mc and J.
        """
        arms = [_arm(*(v[:, i] for v in (theta, thetad, thetadd))) for i in (0, 1)]
        zero = 0 * theta[:, 0]
        ends = [
            (ARM * e[0] + side * FOOT, ARM * e[1])
            for side, (e, *_) in zip((-1, 1), arms, strict=True)
        ]
        tip = _meet(*ends)
        rods = [((tip[0] - b[0]) / ROD, (tip[1] - b[1]) / ROD) for b in ends]
        moved = [[(ARM * x, ARM * y) for x, y in arm[1:]] for arm in arms]  # B', B''
        fast = _closed(rods, [_dot(e, b[0]) for e, b in zip(rods, moved, strict=True)])
        slow = [ROD * _square(_less(fast, b[0], ROD)) for b in moved]
        change = _closed(
            rods, [_dot(e, b[1]) - s for e, b, s in zip(rods, moved, slow, strict=True)]
        )
        columns = []
        for j in (0, 1):
            column = []
            turn = (-arms[j][0][1], arms[j][0][0])  # of arm j for a unit of its rate
            shift = [_times(ARM, turn) if i == j else (zero, zero) for i in (0, 1)]
            lift = _closed(rods, [_dot(e, b) for e, b in zip(rods, shift, strict=True)])
            for i in (0, 1):
                mine = 1.0 if i == j else 0.0
                column += [mine * GRAVITY * arms[i][0][0], mine * thetadd[:, i]]
            for i in (0, 1):
                felt = (moved[i][1][0], moved[i][1][1] + GRAVITY)
                bend, de = _less(change, moved[i][1], ROD), _less(lift, shift[i], ROD)
                column += [
                    _dot(felt, shift[i]),
                    _dot(felt, de) + _dot(bend, shift[i]),
                    _dot(bend, de),
                ]
            columns.append(np.stack(column, axis=1))
        return np.stack(columns, axis=1)


def _arm(q, v, a):
    """Direction of an arm, its first and second derivative by time."""
    c, s = np.cos(q), np.sin(q)
    return (c, s), (-s * v, c * v), (-s * a - c * v**2, c * a - s * v**2)


def _meet(b1, b2):
    """Where rods from two points meet, the point on the left of the way from one to the other."""
    dx, dy = b2[0] - b1[0], b2[1] - b1[1]
    high = np.sqrt(ROD**2 / (dx**2 + dy**2) - 0.25)
    return (b1[0] + b2[0]) / 2 - high * dy, (b1[1] + b2[1]) / 2 + high * dx


def _closed(rods, along):
    """The vector whose parts along both rods are given: what keeps their lengths."""
    (x1, y1), (x2, y2) = rods
    det = x1 * y2 - y1 * x2
    return (along[0] * y2 - along[1] * y1) / det, (x1 * along[1] - x2 * along[0]) / det


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1]


def _less(a, b, length):
    return (a[0] - b[0]) / length, (a[1] - b[1]) / length


def _times(factor, a):
    return factor * a[0], factor * a[1]


def _square(a):
    return a[0] ** 2 + a[1] ** 2

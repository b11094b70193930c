"""A base that does not stand level."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca

from flexhex.fmus.common.effects.effect import Effect, Experiment, Expr, Gain


class GravityTilt(Effect):
    """The base is turned by tilt_x about x and tilt_y about y; gravity turns the other way.

    It is a property of the whole machine, so it lists no axes. Plant, feedforward and
    regressor all use the tilted direction; it is not estimated, since masses and tilt only
    show as products.
    """

    id, title, acts_on = "gravity_tilt", "tilted base", "mechanism"
    gains = (
        Gain("tilt_x", "rad", 0.01, -0.5, 0.5, "turn of the base about x"),
        Gain("tilt_y", "rad", 0.01, -0.5, 0.5, "turn of the base about y"),
    )
    excites = "slow motion of the platform through much of its workspace"
    confused_with = ("quadratic_stiffness",)
    experiment = "slow triangle with and without payload"
    spec = Experiment("triangle", {"speed": 0.1, "amplitude": 0.19}, ((0.0, 0.0), (25.0, 1.0)))

    def mechanism(self, gravity: ca.SX, gains: Mapping[str, Any]) -> Expr:
        """R_x(-tilt_x) R_y(-tilt_y) g."""
        c, s = ca.cos(gains["tilt_y"]), ca.sin(gains["tilt_y"])
        x, y, z = gravity[0], gravity[1], gravity[2]
        x, z = c * x - s * z, s * x + c * z
        c, s = ca.cos(gains["tilt_x"]), ca.sin(gains["tilt_x"])
        return ca.vertcat(x, c * y + s * z, c * z - s * y)


EFFECT = GravityTilt()

"""Arms that the diagnosis knows by name: tables, no equations."""

from __future__ import annotations

from math import pi

from flexhex.diagnosis.basemodels.serial import Arm, Link

SCHUNK = Arm(
    links=(
        Link((0.0, 0.0, 0.11), (0.0, 0.0, 0.0), 1.7, (0.0, 0.0, 0.0)),
        Link((0.0, 0.0, 0.0), (pi / 2, 0.0, 0.0), 1.7, (0.0, 0.175, 0.0)),
        Link((0.0, 0.350, 0.0), (0.0, pi, 0.0), 2.1, (0.0, 0.0, 0.0)),
        Link((0.0, 0.0, 0.0), (-pi / 2, pi, 0.0), 1.7, (0.0, 0.0, 0.15)),
        Link((0.0, 0.005, 0.305), (pi / 2, 0.0, pi), 0.8, (0.0, 0.0, 0.0)),
        Link((0.0, 0.0, 0.0), (-pi / 2, 0.0, 0.0), 0.8, (0.0, 0.0, 0.04)),
    ),
    gravity=(0.0, 0.0, 0.0),
    misplaced=0.0,
)
"""Schunk LWA 4P. Lengths and axes: the description published for ROS (schunk_description,
lwa4p); masses: its rounded placeholders; centres of mass: assumed half way; none of them is fitted,
since slow moves behind gears of a hundred show rotors, not links; nor is the geometry, which acts
through them. Gravity: none, since the torques
of the published runs are zero at rest in every pose, the weight is held otherwise."""

"""The loop of [SH, Fig. 3] as a `System`: which FMUs, how they are wired, how it is drawn."""

from __future__ import annotations

from collections.abc import Mapping

from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import Interface
from flexhex.ssp.system import BASE_STEP, Box, Component, System

# name: FMU, box; [SH, Fig. 3]: the reference on the left, N_F and F above, C and P in the
# middle, and below, from right to left, W, N_E and K (with E).
_LAYOUT: dict[str, tuple[str, Box]] = {
    "reference": ("reference", (0, 160, 100, 240)),
    "N_F": ("kinematics", (180, 320, 280, 400)),
    "F": ("feedforward", (360, 320, 460, 400)),
    "feedback": ("feedback", (360, 160, 460, 240)),
    "plant": ("plant", (560, 160, 660, 240)),
    "W": ("filter", (660, 0, 560, 80)),
    "N_E": ("kinematics", (460, 0, 360, 80)),
    "K": ("estimator", (280, 0, 180, 80)),
}

PLAYER = "player"
"""Of wanted poses: a component before `reference`, which then is the inverse kinematics."""
_PLAYER_BOX: Box = (-160, 160, -60, 240)

_ROUTES: dict[tuple[str, str], tuple[float, ...]] = {
    ("reference", "N_F"): (140,),
    ("reference", "feedback"): (230,),
    ("reference", "plant"): (120, 130, 530),
    (PLAYER, "plant"): (-40, 130, 530),
    ("N_F", "F"): (320,),
    ("K", "F"): (160, 300, 340),
    ("F", "feedback"): (480, 282, 322),
    ("feedback", "plant"): (510,),
    ("plant", "feedback"): (690, 264, 342),
    ("plant", "W"): (690,),
    ("W", "N_E"): (510,),
    ("N_E", "K"): (320,),
    ("W", "K"): (540, -30, 300),
}

_CONNECTIONS = (
    ("reference.r", "N_F.theta"),
    ("reference.rd", "N_F.thetad"),
    ("reference.rdd", "N_F.thetadd"),
    ("reference.r", "feedback.r"),
    ("reference.payload", "plant.payload"),
    *((f"N_F.{name}", f"F.{name}") for name in ("x", "xd", "xdd", "z")),
    ("K.p", "F.p"),
    ("F.tau_ff", "feedback.tau_ff"),
    ("feedback.tau", "plant.tau"),
    ("plant.theta", "feedback.theta"),
    ("plant.theta", "W.theta"),
    ("plant.tau_meas", "W.tau_meas"),
    ("W.theta_f", "N_E.theta"),
    ("W.theta_fd", "N_E.thetad"),
    ("W.theta_fdd", "N_E.thetadd"),
    *((f"N_E.{name}", f"K.{name}") for name in ("x", "xd", "xdd")),
    ("W.chi_f", "K.chi_f"),
    ("W.tau_f", "K.tau_f"),
)

INSTANCES = {instance: block for instance, (block, _) in _LAYOUT.items()}
"""Component of the loop -> FMU folder it is built from."""
TORQUE_PATH = ("reference", "N_F", "F", "feedback", "plant")
_PATHS = (TORQUE_PATH, ("W", "N_E", "K"), ("W", "K"))
_NOT_PLOTTED = {"p_std"}


def hexapod(
    interfaces: Mapping[str, Interface],
    *,
    name: str = "hexapod",
    base: float = BASE_STEP,
    sources: Mapping[str, str] | None = None,
) -> System:
    """The loop of [SH, Fig. 3]; with an interface `player` the one that follows wanted poses.

    interfaces: by FMU (`kinematics` serves N_F and N_E) or by instance name, which wins.
    sources: FMU file by instance name, where it is not `<interface name>.fmu`.
    Raises InterfaceError for an FMU that is missing and for what `System` refuses.
    """
    components, connections = [], list(_CONNECTIONS)
    if player := interfaces.get(PLAYER):
        components.append(Component(PLAYER, player, (sources or {}).get(PLAYER, ""), _PLAYER_BOX))
        connections.remove(("reference.payload", "plant.payload"))
        connections.append((f"{PLAYER}.payload", "plant.payload"))
        wanted = [v.name for v in player.outputs if v.name not in ("payload", "fault")]
        connections += [(f"{PLAYER}.{name}", f"reference.{name}") for name in wanted]
    for instance, (block, box) in _LAYOUT.items():
        interface = interfaces.get(instance) or interfaces.get(block)
        if interface is None:
            raise InterfaceError(f"{instance}: no interface given for the FMU {block!r}")
        source = (sources or {}).get(instance, "")
        components.append(Component(instance, interface, source, box))
    connected = {start for start, _ in connections}
    plots = tuple(
        f"{c.name}.{v.name}"
        for c in components
        for v in c.interface.outputs
        if f"{c.name}.{v.name}" not in connected and v.name not in _NOT_PLOTTED
    )
    return System(name, tuple(components), tuple(connections), base, plots, _PATHS, _ROUTES)

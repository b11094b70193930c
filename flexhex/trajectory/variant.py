"""A .ssp that plays a trajectory file: `reference` becomes a player, or a player and `pose.fmu`."""

from __future__ import annotations

import math
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.fmugen import cache as store
from flexhex.fmugen.blocks import Source, block_interface, step_file, with_starts
from flexhex.fmugen.codegen import SYMBOLIC
from flexhex.fmugen.container_parts import ContainedFmu
from flexhex.fmugen.fmu import build_fmu
from flexhex.fmus.common.errors import InterfaceError
from flexhex.fmus.common.interface import Interface
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import load_machine
from flexhex.fmus.player import equations, interface
from flexhex.fmus.player.table import HEADER, Table, header
from flexhex.ssp.hexapod import INSTANCES, PLAYER, hexapod
from flexhex.ssp.read import Package, read_ssp
from flexhex.ssp.write import write_ssp
from flexhex.tracking import SETTLE
from flexhex.trajectory.motion import read_motion

Array = NDArray[np.float64]
SAME = 1e-9
"""Difference of start values [m, rad, 1] that two computers may find for one machine file: the last
bits are those of their linear algebra."""


@dataclass(frozen=True)
class Variant:
    """A written .ssp; end [s]: the first base step of a run after its motion."""

    path: Path
    end: float


def with_trajectory(
    ssp: Path,
    trajectory: Path,
    machine_file: Path,
    out: Path,
    platforms: Sequence[str] = (),
    begin: float = SETTLE,
) -> Variant:
    """`out/<ssp>-<trajectory>.ssp`, the loop of `ssp` along the motion of a file; `out/player.fmu`.

    The other FMUs are taken as they are. platforms: for which computers the new ones are built.
    begin [s]: rest before the motion.
    Raises TrajectoryError (the file, or what the machine cannot do) and InterfaceError (no
    hexapod.ssp, or one of another machine).
    """
    machine, package = load_machine(machine_file), read_ssp(ssp)
    parts = {
        i.name: ContainedFmu(i.name, package.fmus[i.source]).interface for i in package.instances
    }
    _check(package, parts, machine, machine_file)
    table = read_motion(trajectory, machine)
    interfaces = {name: part for name, part in parts.items() if name not in (PLAYER, "reference")}
    sources = {i.name: Path(i.source).name for i in package.instances if i.name in interfaces}
    path = out / f"{ssp.stem}-{trajectory.stem}.ssp"
    end = math.ceil((begin + table.end) / package.base - 1e-6) * package.base
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        for instance in package.instances:
            (folder / Path(instance.source).name).write_bytes(package.fmus[instance.source])
        player = build_player(table, machine, out, platforms, begin)
        shutil.copyfile(out / "player.fmu", folder / "player.fmu")
        if table.kind == "joints":
            interfaces["reference"] = player
        else:
            pose = Source("pose", machine)
            pose.build_kept(folder, platforms=platforms)
            interfaces |= {PLAYER: player, "reference": pose.interface()}
        system = hexapod(interfaces, name=package.name, base=package.base, sources=sources)
        return Variant(write_ssp(system, folder, path, stop=end), end)


def build_player(
    table: Table,
    machine: Machine,
    out: Path,
    platforms: Sequence[str] = (),
    begin: float = SETTLE,
) -> Interface:
    """`out/player.fmu`, which holds the motion and rests for `begin` [s]; returns its interface."""
    with SYMBOLIC:
        player = with_starts(interface.interface(machine, table.kind), {"t_start": begin})
        functions = equations.functions(machine, table.kind)
        build_fmu(
            player,
            functions,
            step_file("player"),
            out,
            machine.timing.base,
            store.objects(out / "cache"),
            platforms,
            {HEADER: header(table)},
        )
    return player


def _input(interface: Interface, name: str) -> Array:
    """Start values and maximum of an input, as an array."""
    variable = next(v for v in interface.inputs if v.name == name)
    return np.array([*variable.starts, variable.max])


def _same(one: Array, other: Array) -> bool:
    """Whether these are of one mechanism."""
    return one.shape == other.shape and bool(np.allclose(one, other, rtol=SAME, atol=SAME))


def _check(
    package: Package, parts: dict[str, Interface], machine: Machine, machine_file: Path
) -> None:
    """InterfaceError unless it is a loop of this machine whose values are those of its FMUs."""
    for name in INSTANCES:
        if name not in parts:
            raise InterfaceError(f"{package.path}: has no component {name!r}: is it a hexapod.ssp?")
    # the neutral pose of all bodies, and the stroke
    for part, name in (("F", "x"), ("N_F", "theta")):
        own = block_interface(INSTANCES[part], machine)
        if _same(_input(parts[part], name), _input(own, name)):
            continue
        raise InterfaceError(
            f"{package.path}: its mechanism is not that of {machine_file}: name the machine file"
            " that it was built from with --machine"
        )
    for instance in package.instances:
        for name, value in instance.parameters.items():
            if value != instance.fmu.variables[name].start:
                raise InterfaceError(
                    f"{package.path}: its parameter set gives {instance.name}.{name} another value"
                    " than its FMU starts with, which would be lost: build the .ssp with it"
                )

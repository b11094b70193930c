"""What a robot's file shows of its bodies, as triangles in the frames of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.robot_file import Robot, pinocchio, robot_xml
from flexhex.ssp.result import Array

MOST = 10_000
"""Triangles of a machine. In a window of 1440 px more are not seen; without a graphics card a run
with its ghost is drawn half again as often as with 30 000."""
FINEST, COARSEST = 1e-6, 0.1
"""Sides of the cells in which points are taken for one, of the size of the largest body."""
HALVINGS = 12
"""Steps of the search for the finest cells: within a percent of all decades between those two."""
ROUND = 32
"""Corners of a circle."""
PACKAGES = ("package://", "model://")
Faces = NDArray[np.intp]


@dataclass(frozen=True)
class Mesh:
    """points (n, 3) [m], faces (m, 3): places of their corners."""

    points: Array
    faces: Faces


def meshes_of(file: Path, robot: Robot) -> tuple[dict[int, Mesh], str]:
    """A mesh for each axis whose body the file shows, -1 for what does not move; and in a sentence
    what cannot be drawn, or nothing."""
    pin, lost = pinocchio(file), list[str]()
    try:
        if file.suffix == ".xml":
            shown = pin.buildGeomFromMJCF(robot.model, str(file.resolve()), pin.VISUAL)
        else:
            tree = robot_xml(file)
            lost = _locate(file, tree)
            text = ElementTree.tostring(tree, encoding="unicode")
            shown = pin.buildGeomFromUrdfString(robot.model, text, pin.VISUAL)
    except Exception as error:  # Pinocchio's, or those of its readers of meshes
        reason = " ".join((str(error).partition("message: ")[2] or str(error)).split())
        return {}, f"The shapes of {file.name} cannot be read: {reason.rstrip('.')}."
    axes = {place: k for k, place in enumerate(robot.places)} | {0: -1}
    parts: dict[int, list[Mesh]] = {}
    for one in shown.geometryObjects:
        if (mesh := _triangles(one.geometry)) is not None:
            placed = mesh.points @ one.placement.rotation.T + one.placement.translation
            parts.setdefault(axes[one.parentJoint], []).append(Mesh(placed, mesh.faces))
    bodies = {axis: _joined(each) for axis, each in parts.items()}
    return thinned(bodies, MOST), _said(file, lost)


def _said(file: Path, lost: Sequence[str]) -> str:
    if not lost:
        return ""
    more = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
    return (
        f"Bodies whose mesh is missing are drawn as bars: {lost[0]}{more}, looked for in the"
        f" folders above {file.name}."
    )


def _locate(file: Path, tree: ElementTree.Element) -> list[str]:
    """Meshes of a URDF by their paths on this computer; those that are not there are taken out, and
    returned."""
    lost = []
    for link in tree.findall("link"):
        for visual in link.findall("visual"):
            mesh = visual.find("geometry/mesh")
            if mesh is None:
                continue
            name = mesh.get("filename", "")
            path = _path(file.resolve(), name)
            if path is None:
                lost.append(name)
                link.remove(visual)
            else:
                mesh.set("filename", str(path))
    return lost


def _path(file: Path, name: str) -> Path | None:
    """The file of a mesh: beside the robot's, or in a package above; None where there is none."""
    package = next((name.removeprefix(p) for p in PACKAGES if name.startswith(p)), None)
    if package is None:
        tried = [file.parent / name.removeprefix("file://")]
    else:
        tried = [folder / package for folder in file.parents]
    return next((path for path in tried if path.is_file()), None)


def _triangles(shape: Any) -> Mesh | None:
    """The surface of a shape of Coal; None for a plane, which has no end, and clouds of points."""
    kind = type(shape).__name__
    if kind.startswith("BVHModel"):
        corners = [shape.tri_indices(k) for k in range(shape.num_tris)]
        faces = np.array([[c[0], c[1], c[2]] for c in corners], dtype=np.intp).reshape(-1, 3)
        return Mesh(np.asarray(shape.vertices(), dtype=np.float64), faces) if len(faces) else None
    if kind == "Box":
        square = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]], dtype=np.float64)
        ends = np.vstack([np.column_stack([square, np.full(4, z)]) for z in (-1.0, 1.0)])
        return _hull(ends * shape.halfSide, 4)
    quarter = np.linspace(0, np.pi / 2, ROUND // 4 + 1)
    arc = np.column_stack([np.cos(quarter), np.sin(quarter)])
    if kind == "Sphere":
        return _revolved(shape.radius * arc, 0.0)
    if kind == "Ellipsoid":
        ball = _revolved(arc, 0.0)
        return Mesh(ball.points * shape.radii, ball.faces)
    if kind == "Capsule":
        return _revolved(shape.radius * arc, shape.halfLength)
    if kind == "Cylinder":
        return _revolved(shape.radius * np.array([[1.0, 0.0], [0.0, 0.0]]), shape.halfLength)
    return None


def _revolved(arc: Array, half: float) -> Mesh:
    """Of a profile (radius, height) that ends on the axis, above `half`, and the same below."""
    upper = arc + np.array([0.0, half])
    profile = np.vstack([upper[::-1] * np.array([1.0, -1.0]), upper])
    turn = 2 * np.pi * np.arange(ROUND) / ROUND
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    rings = [np.column_stack([r * circle, np.full(ROUND, z)]) for r, z in profile]
    return _hull(np.vstack(rings), ROUND)


def _hull(points: Array, n: int) -> Mesh:
    """Rings of n points above each other, joined; the first and the last one closed."""
    k, quads = np.arange(n), []
    after = (k + 1) % n
    for low in range(0, len(points) - n, n):
        a, b, c, d = low + k, low + after, low + n + after, low + n + k
        quads += [np.column_stack([a, b, c]), np.column_stack([a, c, d])]
    fan = np.column_stack([np.zeros(n - 2, dtype=np.intp), k[1:-1], k[2:]])
    return Mesh(points, np.vstack([*quads, fan[:, ::-1], fan + len(points) - n]))


def _joined(meshes: Sequence[Mesh]) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.points) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.vstack([mesh.points for mesh in meshes]), np.vstack(faces))


def thinned(bodies: dict[int, Mesh], most: int) -> dict[int, Mesh]:
    """The same in as fine cells as leave at most `most` triangles; the points of a cell are one."""
    if not bodies:
        return bodies
    size = max(float(np.ptp(mesh.points, axis=0).max()) for mesh in bodies.values())
    fine = _in_cells(bodies, size * FINEST)
    if _count(fine) <= most:
        return fine
    best = _in_cells(fine, size * COARSEST)
    low, high = np.log(FINEST), np.log(COARSEST)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        tried = _in_cells(fine, size * float(np.exp(middle)))
        if _count(tried) > most:
            low = middle
        else:
            high, best = middle, tried
    return best


def _count(bodies: dict[int, Mesh]) -> int:
    return sum(len(mesh.faces) for mesh in bodies.values())


def _in_cells(bodies: dict[int, Mesh], side: float) -> dict[int, Mesh]:
    return {axis: _coarse(mesh, side) for axis, mesh in bodies.items()}


def _coarse(mesh: Mesh, side: float) -> Mesh:
    """With one point in each cell, the middle of those in it; what has no area left is left out."""
    cells = np.floor((mesh.points - mesh.points.min(axis=0)) / side).astype(np.int64)
    _, cell, count = np.unique(_keys(cells), return_inverse=True, return_counts=True)
    sums = [np.bincount(cell, weights=column) for column in mesh.points.T]
    faces = cell[mesh.faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(_keys(np.sort(faces, axis=1)), return_index=True)
    return Mesh(np.stack(sums, axis=1) / count[:, None], faces[np.sort(first)])


def _keys(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """One number for each of the rows (n, 3) of numbers from 0 up to two millions."""
    x, y, z = rows.T
    return np.asarray((x * (2**21) + y) * (2**21) + z)

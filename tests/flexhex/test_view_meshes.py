"""Shapes of a robot's file: where they are, how fine, and what is said of what is missing."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
import pytest
import typer
from numpy.typing import NDArray

from flexhex.diagnosis.basemodels.robot_file import read_robot
from flexhex.view.meshes import Mesh, meshes_of, thinned
from tests.flexhex.browser import Browser
from tests.flexhex.robot_logs import write
from tests.flexhex.test_view import app, data_of, numbers, shown

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
__all__ = ["app"]
Array = NDArray[np.float64]
HEAVY = (
    '<inertial><mass value="1"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/>'
    "</inertial>"
)
SHAPES = {
    "base": '<origin xyz="0 0 .1"/><geometry><cylinder radius=".1" length=".2"/></geometry>',
    "one": '<origin xyz="0 0 .2" rpy="0 1.5707963267948966 0"/>'
    '<geometry><box size=".1 .2 .4"/></geometry>',
    "two": '<origin rpy="0 0 1.5707963267948966"/><geometry>'
    '<mesh filename="package://arm/meshes/two.stl" scale=".001 .001 .002"/>'
    "</geometry>",
    "tool": '<geometry><sphere radius=".05"/></geometry>',
}
MJCF = """<mujoco><worldbody><geom type="box" size=".2 .2 .1" pos="0 0 .3"/><body name="one">
 <joint name="j1" axis="0 0 1"/><geom type="capsule" size=".05 .2" pos="0 0 .3" mass="1"/>
 <body name="two" pos="0 0 .5"><joint name="j2" axis="0 1 0"/>
 <geom type="ellipsoid" size=".1 .2 .3" mass="1"/></body></body></worldbody></mujoco>"""


def stl(path: Path, triangles: Array) -> None:
    """A binary STL of triangles (n, 3, 3)."""
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = [struct.pack("<12fH", 0, 0, 0, *one.ravel(), 0) for one in triangles]
    path.write_bytes(bytes(80) + struct.pack("<I", len(rows)) + b"".join(rows))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Two joints and a tool on a joint that the log has not; a mesh in millimetres."""
    links = "".join(
        f'<link name="{name}">{HEAVY}<visual>{shape}</visual></link>'
        for name, shape in SHAPES.items()
    )
    names, limit = list(SHAPES), '<limit effort="1" velocity="1" lower="-3" upper="3"/>'
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="{names[k - 1]}"/><child'
        f' link="{names[k]}"/><origin xyz="0 0 .5"/><axis xyz="0 1 0"/>{limit}</joint>'
        for k in (1, 2, 3)
    )
    path = tmp_path / "arm" / "urdf" / "arm.urdf"
    path.parent.mkdir(parents=True)
    path.write_text(f'<robot name="arm">{links}{joints}</robot>')
    corners = np.array([[0, 0, 0], [100, 0, 0], [0, 200, 0], [0, 0, 300]], dtype=np.float64)
    stl(tmp_path / "arm/meshes/two.stl", corners[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]])
    return path


def box(mesh: Mesh) -> list[float]:
    return [*mesh.points.min(axis=0), *mesh.points.max(axis=0)]


def volume(mesh: Mesh) -> float:
    """By the divergence theorem: positive where all faces look outwards."""
    a, b, c = (mesh.points[corner] for corner in mesh.faces.T)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def log(folder: Path) -> Path:
    t = np.arange(1000) * 2e-3
    theta = np.sin(np.outer(t, [2.0, 3.0]))
    return write(folder / "a.csv", t, theta, np.random.default_rng(1).standard_normal((1000, 2)))


def test_shapes_stand_in_the_frames_of_their_joints(file: Path) -> None:
    """The tool, whose joint is locked, belongs to the body before it."""
    bodies, said = meshes_of(file, read_robot(file, ["j1", "j2"], 2))
    assert said == ""
    assert set(bodies) == {-1, 0, 1}
    assert box(bodies[-1]) == pytest.approx([-0.1, -0.1, 0, 0.1, 0.1, 0.2])
    # turned by a quarter about y: its length lies along x
    assert box(bodies[0]) == pytest.approx([-0.2, -0.1, 0.15, 0.2, 0.1, 0.25])
    assert box(bodies[1]) == pytest.approx([-0.2, -0.05, 0, 0.05, 0.1, 0.6])


def test_order_of_the_joints_is_that_of_the_log(file: Path) -> None:
    bodies, _ = meshes_of(file, read_robot(file, ["j2", "j1"], 2))
    assert box(bodies[1]) == pytest.approx([-0.2, -0.1, 0.15, 0.2, 0.1, 0.25])


def test_surfaces_are_closed_and_look_outwards(tmp_path: Path, file: Path) -> None:
    """Volumes, those of round bodies within what 32 corners leave of a circle, 0.7 %."""
    (tmp_path / "arm.xml").write_text(MJCF)
    bodies, said = meshes_of(tmp_path / "arm.xml", read_robot(tmp_path / "arm.xml", [], 2))
    assert said == ""
    assert volume(bodies[-1]) == pytest.approx(0.4 * 0.4 * 0.2)
    capsule = np.pi * 0.05**2 * (0.4 + 4 / 3 * 0.05)
    assert volume(bodies[0]) == pytest.approx(capsule, rel=0.01)
    assert volume(bodies[1]) == pytest.approx(4 / 3 * np.pi * 0.1 * 0.2 * 0.3, rel=0.02)
    others, _ = meshes_of(file, read_robot(file, [], 3))
    assert volume(others[-1]) == pytest.approx(np.pi * 0.1**2 * 0.2, rel=0.01)
    assert volume(others[1]) == pytest.approx(0.1 * 0.2 * 0.6 / 6)


def test_fine_meshes_become_coarse_where_they_were() -> None:
    """A sphere of 80 000 triangles in 5000: no point moves by more than 3 % of its radius."""
    z, turn = np.meshgrid(np.linspace(-1, 1, 201), np.linspace(0, 2 * np.pi, 201))
    r = np.sqrt(1 - z**2)
    points = np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=-1).reshape(-1, 3)
    at = np.arange(len(points)).reshape(201, 201)
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    faces = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    mesh = thinned({0: Mesh(points, faces)}, 5000)[0]
    assert 3000 < len(mesh.faces) <= 5000
    assert np.abs(np.linalg.norm(mesh.points, axis=1) - 1).max() < 0.03
    assert abs(volume(mesh)) == pytest.approx(4 / 3 * np.pi, rel=0.03)
    few = thinned({0: Mesh(points[:4], np.array([[0, 1, 2], [1, 2, 3]]))}, 5000)[0]
    assert np.allclose(np.sort(few.points, axis=0), np.sort(points[:4], axis=0))


def test_page_has_the_shapes(app: typer.Typer, tmp_path: Path, file: Path) -> None:
    data = data_of(shown(app, tmp_path, log(tmp_path), "--base", file, "--joints", "j1,j2"))
    foot, (one, two) = data["machine"]["foot"], data["machine"]["joints"]
    for mesh, size in ((foot, 0.2), (one["mesh"], 0.4), (two["mesh"], 0.25)):
        points = numbers(mesh["points"]).reshape(-1, 3)
        faces = numbers(mesh["faces"])
        assert np.ptp(points[:, 0]) == pytest.approx(size)
        assert set(faces) == set(range(len(points)))
    assert data["said"] == ""


def test_missing_mesh_is_named_and_its_body_drawn_as_bars(
    app: typer.Typer, tmp_path: Path, file: Path
) -> None:
    (tmp_path / "arm/meshes/two.stl").unlink()
    data = data_of(shown(app, tmp_path, log(tmp_path), "--base", file, "--joints", "j1,j3"))
    assert "package://arm/meshes/two.stl" in data["said"]
    assert ["mesh" in joint for joint in data["machine"]["joints"]] == [True, True]
    text = file.read_text().replace(SHAPES["tool"], SHAPES["two"])
    file.write_text(text)
    data = data_of(shown(app, tmp_path, log(tmp_path), "--base", file, "--joints", "j1,j3"))
    assert ["mesh" in joint for joint in data["machine"]["joints"]] == [True, False]


def test_damaged_mesh_is_said_and_bars_are_drawn(
    app: typer.Typer, tmp_path: Path, file: Path
) -> None:
    (tmp_path / "arm/meshes/two.stl").write_bytes(b"solid nothing")
    data = data_of(shown(app, tmp_path, log(tmp_path), "--base", file, "--joints", "j1,j2"))
    assert re.fullmatch(r"The shapes of arm.urdf cannot be read: [^\n]*[^.]\.", data["said"])
    assert "two.stl" in data["said"]
    assert "foot" not in data["machine"]


def test_shapes_are_drawn_in_the_colours_of_their_joints(
    browser: Browser, app: typer.Typer, tmp_path: Path, file: Path
) -> None:
    """The box of the first joint has sharp edges: each of its normals is one of a face."""
    shown(app, tmp_path, log(tmp_path), "--base", file, "--joints", "j1,j2")
    browser.open(tmp_path / "page.html")
    normals = "[...real.hubs[0].mesh.geometry.attributes.normal.array]"
    sent = np.reshape(browser.run(normals), (-1, 3))
    assert len(sent) == 3 * 12
    assert np.allclose(np.sort(np.abs(sent), axis=1), [0, 0, 1], atol=1e-6)
    round_ones = "[...geometryOf(DATA.machine.foot).attributes.normal.array]"
    sides = np.reshape(browser.run(round_ones), (-1, 3))
    assert np.allclose(np.linalg.norm(sides, axis=1), 1, atol=1e-6)
    places = np.reshape(
        browser.run("[...geometryOf(DATA.machine.foot).attributes.position.array]"), (-1, 3)
    )
    flat = np.abs(sides[:, 2]) > 0.5
    way = places[~flat, :2] / np.linalg.norm(places[~flat, :2], axis=1)[:, None]
    # a flat side would be off by 0.098; of a quadrilateral one triangle is at the corner, or both
    assert np.allclose(way, sides[~flat, :2], atol=0.05), "round from corner to corner"
    # the sky is what most of the picture shows
    pictures = []
    for t in (0.5, 1.2):
        browser.run(f"setColour('torque'); setTime({t})")
        pictures.append(browser.pixels())
    assert (np.abs(pictures[0] - pictures[1]).max(axis=2) > 40).mean() > 0.005
    reds = browser.run("real.hubs.map(hub => hub.color.r)")
    shares = browser.run("shares(DATA.runs[0])")
    assert np.argmax(reds) == np.argmax(shares)
    assert browser.said == []

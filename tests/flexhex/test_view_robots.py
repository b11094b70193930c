"""`flexhex view --base`: logs of other machines, as bodies where the base model knows them."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from numpy.typing import NDArray
from typer.testing import CliRunner

from examples.five_bar.five_bar import ARM, FOOT, ROD
from flexhex.diagnosis.jointfit.smoothed import fitted
from flexhex.diagnosis.prepare import Options, run_set_of
from flexhex.fmus.common.errors import MachineError
from flexhex.view.command import view_command
from tests.conftest import ROOT
from tests.diagnosis.robots.simulated import FILE
from tests.flexhex.robot_logs import AXIS, FIVE_BAR, RUBBED, arm_log, write
from tests.flexhex.test_view import data_of, numbers, shown

pin = pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
Array = NDArray[np.float64]
SCRIPTS = [ROOT / "flexhex" / "view" / "page" / name for name in ("kinematics.js", "robot.js")]
RUN = """
const fs = require("fs"), given = JSON.parse(fs.readFileSync(0, "utf8"));
const body = process.argv.slice(1).map(file => fs.readFileSync(file, "utf8")).join("\\n")
  .replaceAll('"use strict";', "") + `
  return given.angles.map(theta => treeFrames(given.joints, theta));`;
console.log(JSON.stringify(new Function("given", body)(given)));
"""
TREE = """<mujoco><compiler angle="radian"/><worldbody><body name="cart" pos="0 0 .4"><joint
 name="rail" type="slide" axis="1 0 0"/><inertial pos="0 0 .1" mass="2" diaginertia=".1 .1 .1"/>
 <body name="left" pos="0 .2 0"><joint name="a" type="hinge" axis="0 .6 .8"/>
 <inertial pos=".1 0 -.2" mass="1" diaginertia=".02 .03 .02"/></body>
 <body name="right" pos="0 -.2 0" euler=".3 .5 -.4"><joint name="b" type="hinge" axis="0 1 0"/>
 <inertial pos="0 .1 -.3" mass=".5" diaginertia=".01 .02 .015"/></body></body></worldbody></mujoco>
"""


@pytest.fixture
def app() -> typer.Typer:
    application = typer.Typer()
    application.command("view")(view_command)
    application.callback()(lambda: None)
    return application


def signal(data: dict[str, Any], name: str, run: int = 0) -> dict[str, Any]:
    entry: dict[str, Any] = next(one for one in data["runs"][run]["signals"] if one["name"] == name)
    return entry


def in_node(joints: list[dict[str, Any]], angles: Array) -> Any:
    """Frames that the page computes for angles (n, axes)."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node on the PATH")
    done = subprocess.run(
        [node, "-e", RUN, *map(str, SCRIPTS)],
        input=json.dumps({"joints": joints, "angles": angles.tolist()}),
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return json.loads(done.stdout)


@pytest.mark.parametrize("kind", ["arm", "tree", "order"])
def test_bodies_stand_where_pinocchio_has_them(app: typer.Typer, tmp_path: Path, kind: str) -> None:
    """An arm; a tree on a rail with skew axes; the same with its joints in another order."""
    file, order = FILE, [f"j{k}" for k in range(1, 7)]
    if kind != "arm":
        file, order = tmp_path / "tree.xml", ["rail", "a", "b"]
        file.write_text(TREE)
    order = ["b", "rail", "a"] if kind == "order" else order
    rng, t = np.random.default_rng(3), np.arange(1000) * 2e-3
    theta = 0.3 * np.sin(t[:, None] * (1 + np.arange(len(order))) + rng.uniform(0, 6, len(order)))
    slides = "".join("l" if name == "rail" else "r" for name in order)
    log = write(tmp_path / "a.csv", t, theta, rng.standard_normal(theta.shape), slides)
    words = [] if kind == "arm" else ["--joints", ",".join(order)]
    data = data_of(shown(app, tmp_path, log, "--base", file, *words))
    assert data["machine"]["kind"] == "tree"
    assert data["machine"]["names"] == order
    build = pin.buildModelFromUrdf if kind == "arm" else pin.buildModelFromMJCF
    model = build(str(file))
    state, picked = model.createData(), theta[:: len(theta) // 5]
    places = [model.getJointId(name) for name in order]
    for row, frames in zip(picked, in_node(data["machine"]["joints"], picked), strict=True):
        moved = np.zeros(model.nv)
        moved[[model.joints[place].idx_v for place in places]] = row
        pin.forwardKinematics(model, state, pin.integrate(model, pin.neutral(model), moved))
        for place, frame in zip(places, frames, strict=True):
            at = state.oMi[place]
            # JSON carries nanometres
            assert np.allclose(frame["x"], at.translation, atol=1e-7)
            w, *v = frame["q"]
            assert np.allclose(pin.Quaternion(w, *v).matrix(), at.rotation, atol=1e-7)
    if kind == "arm":
        assert data["machine"]["joints"][5]["tip"] == pytest.approx([0, 0, 0.05]), "the tool"


def test_residual_is_that_of_the_diagnosis(app: typer.Typer, tmp_path: Path) -> None:
    """The base model fitted to all logs; times count from the first angle, what has none is NaN."""
    logs = [arm_log(tmp_path / f"a{k}.csv", k, delay=5.0 * k) for k in (1, 2)]
    data = data_of(shown(app, tmp_path, *logs, "--base", FILE))
    base, run_set, _ = run_set_of(logs, [], None, Options(str(FILE)))
    calibrated, _, _ = fitted(base, run_set.runs)
    wanted = calibrated.residual(calibrated.regression.q)
    for k, log in enumerate(logs):
        block = next(i for i, b in enumerate(calibrated.blocks) if b.run.name == str(log))
        sent = signal(data, "residual", k)
        assert sent["units"] == ["N m"] * 6
        for axis in (0, 2):
            line = sent["lines"][axis]
            values = numbers(line["values"])
            t = line["t0"] + line["step"] * np.arange(len(values))
            known = np.isfinite(values)
            assert np.allclose(values[known], wanted[block][:, axis].astype("f4"))
            assert np.allclose(t[known], calibrated.blocks[block].at - 5.0 * (k + 1), atol=0.01)
        # friction that the model lacks is what is left
        left = numbers(sent["lines"][2]["values"])
        assert np.nanmedian(np.abs(left)) == pytest.approx(RUBBED, rel=0.15)
        torque, model = (signal(data, name, k) for name in ("tau_smooth", "tau_model"))
        both = [numbers(one["lines"][2]["values"]) for one in (torque, model)]
        assert np.allclose(both[0] - both[1], left, atol=1e-5, equal_nan=True)
    assert 0 < data["settled"] < 0.5, "the page begins where the fit does"


def test_axes_have_signals_and_say_why_there_is_no_picture(
    app: typer.Typer, tmp_path: Path
) -> None:
    """Nothing of the 3D library is in the page then."""
    text = shown(app, tmp_path, AXIS / "a1.csv", "--base", "axis")
    data = data_of(text)
    assert (data["machine"]["kind"], data["machine"]["names"]) == ("none", ["joint 1"])
    assert "no picture" in data["machine"]["text"]
    assert "OrbitControls.js" not in re.sub(r"<script>.*?</script>", "", text, flags=re.S)
    assert np.isfinite(numbers(signal(data, "residual")["lines"][0]["values"])).sum() > 100


def test_more_than_two_logs_have_each_their_own_time(app: typer.Typer, tmp_path: Path) -> None:
    t = np.arange(3000) * 2e-3
    rng = np.random.default_rng(1)
    logs = []
    for k, seconds in enumerate((2.0, 4.0, 5.998)):
        kept = t <= seconds
        theta = np.sin(2 * t[kept, None] + k)
        tau = -theta + 0.01 * rng.standard_normal(theta.shape)
        logs.append(write(tmp_path / f"a{k}.csv", t[kept], theta, tau))
    data = data_of(shown(app, tmp_path, *logs, "--base", "axis"))
    assert [run["end"] for run in data["runs"]] == pytest.approx([2.0, 4.0, 5.998])
    assert [run["name"] for run in data["runs"]] == ["a0", "a1", "a2"]


def test_axis_that_slides_has_its_units(app: typer.Typer, tmp_path: Path) -> None:
    t = np.arange(1000) * 2e-3
    theta = np.column_stack([np.sin(3 * t), np.cos(5 * t)])
    tau = -theta + 0.01 * np.random.default_rng(1).standard_normal(theta.shape)
    log = write(tmp_path / "a.csv", t, theta, tau, "lr")
    data = data_of(shown(app, tmp_path, log, "--base", "axis"))
    assert signal(data, "theta")["units"] == ["m", "rad"]
    assert signal(data, "residual")["units"] == ["N", "N m"]


def test_own_model_says_where_its_bars_are(app: typer.Typer, tmp_path: Path) -> None:
    """The five-bar of the example: rods of their length that meet, from the ends of the arms."""
    t = np.arange(2000) * 2e-3
    theta = np.array([2.2, 0.9]) + 0.3 * np.sin(np.outer(t, [2.0, 3.0]))
    tau = np.cos(theta) + 0.01 * np.random.default_rng(1).standard_normal(theta.shape)
    log = write(tmp_path / "a.csv", t, theta, tau)
    data = data_of(shown(app, tmp_path, log, "--base", f"{FIVE_BAR}:FiveBar"))
    frames = data["runs"][0]["frames"]
    bars = numbers(frames["bars"]).reshape(frames["count"], 4, 2, 3)
    lengths = np.linalg.norm(bars[:, :, 1] - bars[:, :, 0], axis=2)
    assert np.allclose(lengths, [ARM, ARM, ROD, ROD], atol=1e-6)
    assert np.allclose(bars[:, :2, 0], [[-FOOT, 0, 0], [FOOT, 0, 0]])
    assert np.allclose(bars[:, 2:, 0], bars[:, :2, 1])
    assert np.allclose(bars[:, 2, 1], bars[:, 3, 1])
    way = bars[:, :2, 1] - bars[:, :2, 0]
    sent = numbers(frames["theta"]).reshape(-1, 2)
    assert np.allclose(np.arctan2(way[..., 2], way[..., 0]), sent, atol=1e-6)


@pytest.mark.parametrize(
    ("bars", "reason"),
    [
        ("return np.zeros((len(theta), 1, 2, 3))", "must be (1, bars, 2, 3), with at least a bar"),
        ("return theta", "bars returned shape (1, 2)"),
        ("return missing", "bars: NameError: name 'missing' is not defined (line 6)"),
    ],
)
def test_bars_that_are_none_are_refused(
    app: typer.Typer, tmp_path: Path, bars: str, reason: str
) -> None:
    file = tmp_path / "own.py"
    file.write_text(
        "import numpy as np\nclass Own:\n    parameters = (('J', 'kg m2'),)\n"
        "    def columns(self, q, v, a): return a[:, :, None]\n"
        f"    def bars(self, theta):\n        {bars}\n"
    )
    t = np.arange(500) * 2e-3
    log = write(tmp_path / "a.csv", t, np.sin(np.outer(t, [2.0, 3.0])), np.ones((500, 2)))
    done = CliRunner().invoke(app, ["view", str(log), "--base", f"{file}:Own"])
    assert isinstance(done.exception, MachineError)
    assert reason in str(done.exception)


def test_log_that_is_too_short_for_a_fit_is_shown_without_a_residual(
    app: typer.Typer, tmp_path: Path
) -> None:
    t = np.arange(60) * 2e-3
    rng = np.random.default_rng(1)
    log = write(tmp_path / "a.csv", t, np.sin(9 * t[:, None]), rng.standard_normal((60, 1)))
    data = data_of(shown(app, tmp_path, log, "--base", "axis"))
    assert data["said"].startswith("No residual: ")
    assert "are needed" in data["said"]
    assert data["runs"][0]["frames"]["residual"] is None

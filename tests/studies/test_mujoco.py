"""Logs of machines in MuJoCo: where the truth lies, what is hidden, and how it is measured."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import h5py
import mujoco
import numpy as np
import pytest

from flexhex.fmus.common.machine_file import load_machine
from studies.mujoco import draw as drawing
from studies.mujoco import hexapod, inside, outside
from studies.mujoco.case import Case, Wanted
from studies.mujoco.draw import draw
from studies.mujoco.machine import Array, rotation
from studies.mujoco.make import make
from studies.mujoco.model import compiled, inverse, places
from studies.mujoco.observable import contribution, observable
from studies.mujoco.runs import Simulated, runs_of
from studies.mujoco.simulate import Record
from studies.mujoco.truth import truth_of

SEED = 5
FEW = 6000


@pytest.fixture(autouse=True)
def _short_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawing, "MOST_STEPS", FEW)


def quiet(case: Case) -> Case:
    """A case of one trajectory and pass without disturbance."""
    still = replace(case.noise, disturbance=0.0)
    return replace(case, noise=still, trajectories=case.trajectories[:1], passes=1)


def hidden(id: str, kind: str) -> Simulated:
    """A quiet case with one effect of 5 % on the first axis."""
    case = draw(SEED, "nothing", kind)
    wanted = Wanted(id, (0,), 0.05, 3)
    return runs_of(quiet(replace(case, hidden=(wanted,))))


def unexplained(case: Case, record: Record) -> Array:
    """Share of each axis' torque that MuJoCo's rigid machine does not ask for."""
    model = compiled(case.machine, case.step, ())
    at = record.at
    if model.neq:
        rigid = inverse(model, record.q, record.v, record.a)[:, at]
    else:
        rigid = inverse(model, record.q[:, at], record.v[:, at], record.a[:, at])
    left = record.u + record.disturbance - rigid
    return np.asarray(np.sqrt(np.mean(left**2, axis=0) / np.mean(record.u**2, axis=0)))


def test_truth_lies_apart_from_the_logs(tmp_path: Path) -> None:
    written = make(SEED, tmp_path / "logs", tmp_path / "sealed", category="single", kind="axis")
    truth = json.loads(written.sealed.read_text())
    for path in (tmp_path / "logs").iterdir():
        assert truth["hidden"][0]["id"].encode() not in path.read_bytes()
    assert {p.parent for p in (*written.paths, *written.test_paths, written.machine_file)} == {
        tmp_path / "logs"
    }
    with pytest.raises(ValueError, match="apart"):
        make(SEED, tmp_path / "logs", tmp_path / "logs" / "truth")


def test_test_seeds_are_refused_unless_meant(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="--test"):
        make(10_000, tmp_path / "logs", tmp_path / "sealed")


def test_a_seed_gives_the_same_files_twice(tmp_path: Path) -> None:
    texts = []
    for name in ("one", "two"):
        written = make(SEED, tmp_path / name, tmp_path / f"sealed-{name}", category="nothing")
        files = [*written.paths, *written.test_paths]
        columns = [_numbers(path) for path in files]
        texts.append((written.sealed.read_text(), written.machine_file.read_text(), columns))
    assert texts[0] == texts[1]
    other = make(SEED + 1, tmp_path / "three", tmp_path / "sealed-three", category="nothing")
    assert other.machine_file.read_text() != texts[0][1]


def _numbers(path: Path) -> list[bytes]:
    if path.suffix == ".csv":
        return [path.read_bytes()]
    with h5py.File(path) as file:
        return [np.asarray(file[name]).tobytes() for name in sorted(file)]


@pytest.mark.parametrize("kind", ["axis", "gantry", "arm", "hexapod"])
def test_without_an_effect_nothing_is_unexplained(kind: str) -> None:
    case = draw(SEED, "nothing", kind)
    (passes, *_) = runs_of(replace(case, trajectories=case.trajectories[:1], passes=1)).records
    # forward and inverse dynamics of MuJoCo agree to rounding; the disturbance is known here
    assert unexplained(case, passes[0]).max() < 1e-6
    nothing = [np.zeros_like(passes[0].u)]
    assert observable(case, nothing, passes).max() == 0.0
    assert truth_of(runs_of(quiet(case)))["hidden"] == []


@pytest.mark.parametrize(
    ("kind", "id"),
    [
        ("axis", "coulomb_friction"),
        ("axis", "cogging_harmonic"),
        ("gantry", "drive_lag"),
        ("gantry", "cross_coupling"),
        ("arm", "torque_ripple"),
        ("arm", "second_hysteresis"),
        ("axis", "bump"),
        ("gantry", "dead_zone"),
        ("hexapod", "coulomb_friction"),
        ("hexapod", "torque_ripple"),
    ],
)
def test_an_effect_is_in_the_logs_at_the_size_that_the_truth_says(kind: str, id: str) -> None:
    simulated = hidden(id, kind)
    record, axes = simulated.records[0][0], list(simulated.effects[0].axes)
    seen = unexplained(simulated.case, record)
    torque = contribution(simulated.case, simulated.effects, 0, record)
    size = np.sqrt(np.mean(torque**2, axis=0) / np.mean(record.u**2, axis=0))
    assert seen[axes] == pytest.approx(size[axes], rel=1e-3)
    assert size[axes].min() > 0.01
    others = [k for k in range(simulated.case.machine.n) if k not in axes]
    assert seen[others].max(initial=0.0) < 1e-6


def test_axes_of_a_gantry_stand_at_right_angles_the_third_upright() -> None:
    """Axes that are not would push each other, though nothing is hidden."""
    machine = next(m for m in (draw(s, kind="gantry").machine for s in range(20)) if m.n == 3)
    frame, along = np.eye(3), []
    for link in machine.links:
        frame = frame @ rotation(link.rpy)
        along.append(frame[:, 2])
    assert np.array(along) @ np.array(along).T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.abs(along[2]) == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)


def test_a_gain_of_the_truth_is_that_of_the_machine() -> None:
    simulated = hidden("coulomb_friction", "axis")
    record = simulated.records[0][0]
    friction = truth_of(simulated)["hidden"][0]["parameters"]["F_c"]["value"][0]
    fast = np.abs(record.v[:, 0]) > 0.3 * np.abs(record.v[:, 0]).max()
    jump = contribution(simulated.case, simulated.effects, 0, record)[fast, 0] * np.sign(
        record.v[fast, 0]
    )
    assert jump == pytest.approx(friction, rel=1e-3)


def test_the_lag_of_the_truth_is_that_of_the_actuator() -> None:
    simulated = hidden("drive_lag", "gantry")
    record, step = simulated.records[0][0], 1 / simulated.case.rate
    true_lag = truth_of(simulated)["hidden"][0]["parameters"]["T_lag"]["value"][0]
    command, force = record.ctrl[:, 0], record.force[:, 0]
    rate = np.gradient(command, step)
    smooth = slice(len(rate) // 10, -len(rate) // 10)
    lag = -np.linalg.lstsq(rate[smooth, None], (force - command)[smooth], rcond=None)[0][0]
    # first order of a lag that is small beside the motion, and of differences between samples
    assert lag == pytest.approx(true_lag, rel=0.05)


def test_passes_differ_by_disturbance_and_by_noise() -> None:
    case = replace(draw(SEED, "nothing", "axis"), passes=2)
    one, two = runs_of(replace(case, trajectories=case.trajectories[:1])).records[0]
    assert np.abs(one.u - two.u).max() > 0
    assert np.abs(one.r - two.r).max() == 0


def test_payload_is_on_the_second_half_of_the_passes() -> None:
    case = replace(draw(SEED, "payload", "arm"), passes=2)
    one, two = runs_of(replace(case, trajectories=case.trajectories[:1])).records[0]
    assert unexplained(case, one).max() < 1e-6
    assert unexplained(case, two).max() > 1e-3


def test_every_effect_has_a_name_of_its_own_and_outside_none_is_right() -> None:
    assert not set(inside.MAKERS) & set(outside.MAKERS)
    assert len(outside.MAKERS) >= 6
    for id in ("bump", "backlash", "dead_zone"):
        truth = truth_of(hidden(id, "axis"))["hidden"][0]
        assert truth["accept"] == []
        assert not truth["inside"]
    # load-dependent friction and a torque constant explain it exactly
    truth = truth_of(hidden("one_way_load_friction", "axis"))
    assert truth["hidden"][0]["accept"] == ["load_friction"]
    assert truth["hidden"][0]["inside"]


def test_seeds_draw_a_wide_world() -> None:
    cases = [draw(seed) for seed in range(200)]
    assert {c.category for c in cases} == set(drawing.SHARES)
    assert {c.machine.kind for c in cases} == {"axis", "gantry", "arm", "hexapod"}
    assert min(c.encoder for c in cases) < 1e-7
    assert {c.delay for c in cases} >= set(range(6))
    assert {c.passes for c in cases} == {1, 2, 3, 4}


def test_the_loops_of_the_hexapod_close_and_its_file_is_one_of_the_library(tmp_path: Path) -> None:
    case = draw(SEED, "nothing", "hexapod")
    record = runs_of(quiet(case)).records[0][0]
    model = compiled(case.machine, case.step, ())
    data = mujoco.MjData(model)
    for q in record.q[:: len(record.q) // 10]:
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        ends = data.site_xpos[model.eq_obj1id] - data.site_xpos[model.eq_obj2id]
        # MuJoCo's constraints are a little soft
        assert np.linalg.norm(ends, axis=1).max() < 1e-5 * case.machine.chain.L
    path = tmp_path / "machine.toml"
    path.write_text(hexapod.toml(case.written.chain, 0.19, 0.0314, 0.0027))
    machine = load_machine(path)
    assert (machine.tolerance.mass, machine.tolerance.geometry) == (0.0314, 0.0027)
    assert pytest.approx(case.machine.chain.L, rel=0.03) == machine.geometry.L
    assert machine.geometry.L != case.machine.chain.L


def test_a_payload_on_the_platform_weighs_on_the_cranks() -> None:
    case, mass = draw(SEED, "payload", "hexapod"), 0.5
    chain = case.machine.chain
    heavier = replace(case.machine, chain=hexapod.loaded(chain, mass))
    bare, laden = (compiled(m, case.step, ()) for m in (case.machine, heavier))
    data, lift = mujoco.MjData(bare), np.zeros((3, bare.nv))
    mujoco.mj_forward(bare, data)
    at, q, still = places(bare, 6), data.qpos[None].copy(), np.zeros((1, bare.nv))
    spot = chain.x_E0 + chain.spot
    mujoco.mj_jac(bare, data, lift, None, spot, bare.body("platform").id)
    (V,) = hexapod.projections(bare, q, at)
    more = inverse(laden, q, still, still)[0, at] - inverse(bare, q, still, still)[0, at]
    # virtual work of its weight; the tree is exact
    assert more == pytest.approx(mass * 9.81 * lift[2] @ V, rel=1e-9)

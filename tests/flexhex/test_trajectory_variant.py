"""Own motions in the loop: the mechanism follows them, in every way that they can be run."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from typer.testing import CliRunner

from flexhex.cli import app
from flexhex.fmus.common.errors import InterfaceError
from flexhex.ssp.executor import run
from flexhex.ssp.read import read_ssp
from flexhex.trajectory.variant import with_trajectory
from tests.compare import assert_close
from tests.conftest import MACHINE_FILE, ROOT
from tests.importers.loop import BASE, N_STEPS, libcosim_rows, own_rows, wanted

EXAMPLE = ROOT / "examples" / "motion.csv"
ECOS = "pip install ecospy; apt install libtbb12"
BEGIN = 0.02
"""Rest before the motion in these tests [s], so that runs of importers are short."""
KINDS = ("joints", "poses")


def sweep(folder: Path) -> Path:
    """Angles at 100 Hz for 0.6 s, each joint its own."""
    time = np.arange(61) / 100
    s = time / time[-1]
    step = s**3 * (10 - 15 * s + 6 * s**2)
    values = np.column_stack([3 * k * np.sin(np.pi * step) ** 2 for k in range(-3, 3)])
    table = np.column_stack([time, values]).tolist()
    rows = [",".join(map(repr, row)) for row in table]
    names = "time," + ",".join(f"r[{k}]" for k in range(1, 7))
    path = folder / "sweep.csv"
    path.write_text("\n".join([names, "s" + ",deg" * 6, *rows]) + "\n")
    return path


def circle(folder: Path) -> Path:
    """Nine poses in 2 s: a small circle with a tilt, so coarse that |lam_E| moves between rows."""
    time = np.linspace(0, 2, 9)
    s = time / 2
    angle = 2 * np.pi * s**3 * (10 - 15 * s + 6 * s**2)
    x, y, tilt = 15 * (np.cos(angle) - 1), 15 * np.sin(angle), 2 * np.sin(angle)
    rows = [
        ",".join(map(repr, row))
        for row in np.column_stack(
            [time, x, y, np.full(9, 300.0), tilt, 0 * x, 0 * x, np.linspace(0, 2, 9)]
        ).tolist()
    ]
    names = "time,x_E.x,x_E.y,x_E.z,phi_E.x,phi_E.y,phi_E.z,payload"
    path = folder / "circle.csv"
    path.write_text("\n".join([names, "s,mm,mm,mm,deg,deg,deg,kg", *rows]) + "\n")
    return path


@pytest.fixture(scope="module")
def variants(hexapod_ssp: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The loop along angles and along poses."""
    folder = tmp_path_factory.mktemp("variants")
    files = {"joints": sweep(folder), "poses": circle(folder)}
    return {
        kind: with_trajectory(hexapod_ssp, file, MACHINE_FILE, folder / kind, begin=BEGIN).path
        for kind, file in files.items()
    }


def test_reference_and_kinematics_go_along_the_wanted_poses(variants: dict[str, Path]) -> None:
    """player -> pose -> N_F: the pose comes back, late by what the schedule says."""
    signals = ["player", "reference", "N_F.x", "N_F.xd", "plant.x_E"]
    result = run(variants["poses"], 2.0, signals=signals)
    assert not result["reference.fault"].any()
    player = np.hstack([result["player.x_E"], result["player.lam_E"]])
    rates = np.hstack([result["player.xd_E"], result["player.lamd_E"]])
    length = np.linalg.norm(player[:, 3:], axis=1, keepdims=True)
    assert np.ptp(length) > 1e-9, "the interpolation keeps the length: nothing was shown"
    # N_F samples every second base step what the inverse kinematics shows of the step before
    x, k = result["N_F.x"], np.arange(2, 4000)
    sampled = 2 * k - 2 - 1
    actual = x[k, 30:]
    assert_close(actual[:, :3], player[sampled, :3], atol=1e-10, what="x_E")
    assert_close(actual[:, 3:], (player[:, 3:] / length)[sampled], atol=1e-10, what="lam_E")
    assert_close(result["N_F.xd"][k, 30:33], rates[sampled, :3], atol=1e-10, what="rate")
    assert np.ptp(actual[:, 0]) > 0.02
    # the mechanism itself, 8 base steps behind: a payload of 2 kg that nobody announces moves it
    behind = result["plant.x_E"][4008:] - player[4000:-8, :3]
    assert np.abs(behind).max() < 5e-4


def test_joints_are_played_as_they_stand(variants: dict[str, Path], tmp_path: Path) -> None:
    result = run(variants["joints"], 0.7)
    rows = np.loadtxt(sweep(tmp_path), delimiter=",", skiprows=2)
    at = np.round((BEGIN + rows[:, 0]) / BASE).astype(int)
    assert_close(result["reference.r"][at], np.radians(rows[:, 1:]), atol=1e-15, what="r")
    assert np.abs(result["feedback.e"]).max() < 2e-4


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", KINDS)
def test_variant_passes_the_checks(variants: dict[str, Path], kind: str) -> None:
    words = [sys.executable, "-m", "flexhex", "check", str(variants[kind])]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()[-4:]) == (0, ": ok"), done.stdout + done.stderr


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", KINDS)
def test_fmpy_gives_the_same_bits(variants: dict[str, Path], kind: str) -> None:
    """0.08 s, of which the motion takes 0.06 s: FMPy is slow."""
    steps = 320
    rows = simulate_ssp(str(variants[kind]), stop_time=(steps - 0.5) * BASE, step_size=BASE)
    for name, values in own_rows(variants[kind]).items():
        assert np.array_equal(rows[name], values[:steps]), name
    assert np.ptp(rows["reference.r[1]"]) > 1e-5, "nothing moved"


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", KINDS)
def test_libcosim_gives_the_same_bits(variants: dict[str, Path], tmp_path: Path, kind: str) -> None:
    with zipfile.ZipFile(variants[kind]) as archive:
        archive.extractall(tmp_path)
    loaded = libcosim_rows("from_ssp_file", tmp_path, read_ssp(variants[kind]))
    for name, values in own_rows(variants[kind]).items():
        assert np.array_equal(loaded[name], values), name


def test_ecos_gives_the_same_bits(variants: dict[str, Path]) -> None:
    """At the end of 2 s: a difference anywhere would stay, since all goes round the loop."""
    ecospy, expected = wanted("ecospy", ECOS), own_rows(variants["poses"])
    with ecospy.EcosSimulation(ssp_path=str(variants["poses"]), step_size=BASE) as simulation:
        simulation.init()
        simulation.step(N_STEPS)
        for name, values in expected.items():
            assert simulation.get_real(name.replace(".", "::", 1)) == values[-1], name


def test_command_simulates_the_example_to_its_end(hexapod_ssp: Path, tmp_path: Path) -> None:
    words = ["simulate", str(hexapod_ssp), "--trajectory", str(EXAMPLE), "--json"]
    words += ["-r", str(tmp_path / "result.csv")]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    data = json.loads(done.stdout)
    assert data["duration_s"] == 8.0, "2 s of rest and the 6 s of the file"
    assert data["faults"] == []
    assert data["tracking"]["e_rms_urad"] < 5
    assert set(data["fmus"]) >= {"player", "reference", "plant"}


def test_command_exports_a_variant_that_all_other_exports_take(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    words = ["export", str(hexapod_ssp), "--trajectory", str(EXAMPLE), "--container", "--diagram"]
    done = CliRunner().invoke(app, [*words, "--for", "osp", "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert (tmp_path / "osp" / "player.fmu").exists()
    inside = read_ssp(tmp_path / "hexapod-motion-controller.ssp")
    assert [i.name for i in inside.instances] == ["player", "reference", "controller", "plant"]
    a, b = (run(tmp_path / f"hexapod-motion{end}.ssp", 2.5) for end in ("", "-controller"))
    assert np.array_equal(a["plant.theta"], b["plant.theta"])
    assert np.ptp(a["plant.theta"]) > 1e-3


def test_a_variant_takes_another_trajectory(
    variants: dict[str, Path], hexapod_ssp: Path, tmp_path: Path
) -> None:
    """The player and the inverse kinematics of the first leave nothing behind."""
    anew = with_trajectory(variants["poses"], sweep(tmp_path), MACHINE_FILE, tmp_path, begin=BEGIN)
    assert [i.name for i in read_ssp(anew.path).instances] == [
        i.name for i in read_ssp(hexapod_ssp).instances
    ]
    a, b = run(anew.path, 0.7), run(variants["joints"], 0.7)
    assert np.array_equal(a["plant.theta"], b["plant.theta"])


def test_another_machine_is_refused(hexapod_ssp: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.toml"
    text = MACHINE_FILE.read_text(encoding="utf-8")
    assert "value = 0.5235987755982988" in text
    other.write_text(text.replace("value = 0.5235987755982988", "value = 0.5"))
    with pytest.raises(InterfaceError, match=r"its mechanism is not that of .*other.toml"):
        with_trajectory(hexapod_ssp, EXAMPLE, other, tmp_path)


def test_a_mechanism_that_another_computer_calculated_is_the_same(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """Its linear algebra has other last bits; a height off by some of them stands for it."""
    other, text = tmp_path / "other.toml", MACHINE_FILE.read_text(encoding="utf-8")
    moved, count = re.subn(r"(x_E0 = \{ value = \[0.0, 0.0, 0.3)\]", r"\g<1>0000000000001]", text)
    assert count == 1
    other.write_text(moved, encoding="utf-8")
    assert with_trajectory(hexapod_ssp, EXAMPLE, other, tmp_path).path.is_file()


def test_values_that_would_be_lost_are_refused(hexapod_ssp: Path, tmp_path: Path) -> None:
    changed = tmp_path / "changed.ssp"
    with zipfile.ZipFile(hexapod_ssp) as old, zipfile.ZipFile(changed, "w") as new:
        for name in old.namelist():
            data = old.read(name)
            if name == "resources/N_F.ssv":
                entry = r'(name="corrections">\s*<ssv:Integer value=)"1"'
                text, count = re.subn(entry, r'\1"2"', data.decode())
                assert count == 1
                data = text.encode()
            new.writestr(name, data)
    with pytest.raises(InterfaceError, match=r"gives N_F.corrections another value than its FMU"):
        with_trajectory(changed, EXAMPLE, MACHINE_FILE, tmp_path)


def test_a_system_without_the_loop_is_refused(hexapod_ssp: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.ssp"
    with zipfile.ZipFile(hexapod_ssp) as old, zipfile.ZipFile(other, "w") as new:
        for name in old.namelist():
            data = old.read(name)
            new.writestr(name, data.replace(b'"N_F"', b'"N"') if name.endswith(".ssd") else data)
    with pytest.raises(InterfaceError, match=r"has no component 'N_F': is it a hexapod.ssp\?"):
        with_trajectory(other, EXAMPLE, MACHINE_FILE, tmp_path)

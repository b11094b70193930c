"""What `identify` writes of a robot is the whole model: its file and the TOML beside it."""

from __future__ import annotations

from pathlib import Path

import pytest

import flexhex
from flexhex.fmus.common.errors import UsageError
from flexhex.identify.write_other import checked_target
from tests.compare import assert_close
from tests.diagnosis.robots.stated_arm import (
    DRY,
    ENTRY,
    HELD_OUT,
    PER_TURN,
    RIPPLE,
    RUNS,
    VISCOUS,
    arm,
    base_for,
    listed,
)

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")


def test_written_files_are_the_whole_model(tmp_path: Path) -> None:
    """Read back, they leave little of the torque, but for what a library's friction has not: that
    of MuJoCo turns over before the rate does. URDF alone leaves more."""
    runs = dict(runs=RUNS, held_out=HELD_OUT)
    ripple = ENTRY.format("cogging_harmonic", 3, f"a = 0\nb = 0.1\norder = {PER_TURN}")
    file = arm(tmp_path, (0.4, 1.5, 0.5), VISCOUS, ripple)
    first = flexhex.identify_runs(**runs, base=str(file))
    assert first["F_c[1]"].file == 0.4
    assert abs(first["F_c[1]"].estimate.value - DRY[0]) < 0.05
    assert first["cogging_harmonic.b[3]"].file == 0.1
    assert abs(first["cogging_harmonic.b[3]"].estimate.value - RIPPLE) < 0.01
    assert first.simulation is not None
    assert not first.simulation.bare
    written = flexhex.save_identified(first, tmp_path / "made.urdf")
    assert tmp_path / "made.toml" in written.files
    again = flexhex.identify_runs(**runs, base=str(tmp_path / "made.toml"))
    assert first.held_out is not None
    assert again.held_out is not None
    assert (again.held_out.file < 0.02).all()
    assert [n for n in written.notes if "friction on axes 1, 2 and 3 turns over" in n]
    bare = flexhex.identify_runs(**runs, base=str(tmp_path / "made.urdf"))
    assert bare.held_out is not None
    assert (bare.held_out.file > 1.5 * again.held_out.file).all()


OWN = """class Spring:
    gains = (("k", "N m/rad"),)

    def columns(self, axis):
        return axis.theta[:, None]
"""


def test_an_effect_of_ones_own_is_seen_from_the_toml(tmp_path: Path) -> None:
    (tmp_path / "spring.py").write_text(OWN)
    entry = ENTRY.format("spring.py:Spring", 2, 'k = { value = 12, unit = "N m/rad" }')
    (use,) = base_for(arm(tmp_path, (0,) * 3, (0,) * 3, entry)).stated.uses
    assert use.own is not None
    assert use.gains == ((12.0,),)
    file = arm(tmp_path, more=entry)
    found = flexhex.identify_runs(RUNS, HELD_OUT, base=str(file))
    spring = found["spring.k[2]"]
    assert spring.file == 12.0
    # it has none
    assert spring.estimate.ci95[0] < 0 < spring.estimate.ci95[1]
    made = tmp_path / "made.urdf"
    assert flexhex.save_identified(found, made)
    assert 'id = "spring.py:Spring"' in made.with_suffix(".toml").read_text()


def test_what_does_nothing_in_these_runs_stays_as_it_was(tmp_path: Path) -> None:
    """A cable that is never tight; and a wave that the arm has not."""
    cable = ENTRY.format("cable_force", 1, "k_c = 5\ntheta_0 = 100\nside = 1")
    wave = ENTRY.format("cogging_harmonic", 2, "a = 0\nb = 0.1\norder = 11")
    found = flexhex.identify_runs(RUNS, base=str(arm(tmp_path, more=cable + wave)))
    assert_close(found["cable_force.k_c[1]"].estimate.value, 5.0, rtol=1e-9)
    assert not found["cable_force.k_c[1]"].determined
    (said,) = [note for note in found.notes if "show nothing of it" in note]
    assert "cogging_harmonic of axis 2" in said


def test_a_toml_of_somebody_else_is_not_overwritten(tmp_path: Path) -> None:
    file = arm(tmp_path)
    (tmp_path / "arm.urdf").rename(tmp_path / "other.urdf")
    file.write_text('robot = "other.urdf"\n')
    with pytest.raises(UsageError, match=r"arm.urdf: .*arm.toml would be overwritten, too"):
        checked_target(tmp_path / "arm.urdf", str(file))
    # one that `identify` wrote is
    file.write_text("# What `flexhex identify` found beside arm.urdf\n")
    checked_target(tmp_path / "arm.urdf", str(tmp_path / "other.urdf"))
    (tmp_path / "arm.json").write_text("{}")
    with pytest.raises(UsageError, match=r"arm.urdf: .*arm.json would be overwritten, too"):
        checked_target(tmp_path / "arm.urdf", str(tmp_path / "other.urdf"))


def test_a_rotor_of_nothing_and_a_breakaway_torque_are_written(tmp_path: Path) -> None:
    """Of Stribeck friction the file has what it has a place for."""
    more = "[rotor.column]\ninertia = 0\n" + ENTRY.format(
        "stribeck_friction", 2, "F_c = 1.4\nF_s = 0.1\ns_0 = 0.001\nv_s = 0.1"
    )
    found = flexhex.identify_runs(RUNS, base=str(arm(tmp_path, more=more)))
    flexhex.save_identified(found, tmp_path / "made.urdf")
    friction = found["stribeck_friction.F_c[2]"].estimate.value
    assert f'friction="{friction:.6g}'[:15] in (tmp_path / "made.urdf").read_text()
    base = base_for(tmp_path / "made.toml")
    assert_close(listed(base)["stribeck_friction"][1], friction, rtol=1e-12)
    assert listed(base)["coulomb_friction"][1] == 0.0
    assert base.linear[base.rotors[0]].nominal < 1e-8
    assert base.linear[base.rotors[0]].tolerance < 1e-8

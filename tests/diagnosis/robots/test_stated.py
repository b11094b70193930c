"""Effects that a robot's files state: read, and compared with the runs.

The logs are those of `examples/robot`, which MuJoCo made; what is true of them stands there.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import flexhex
from flexhex.fmus.common.errors import MachineError
from tests.compare import assert_close
from tests.diagnosis.estimation.machines import CART
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


def test_friction_and_damping_are_those_of_the_file(tmp_path: Path) -> None:
    base = base_for(arm(tmp_path, viscous=(0.6, 0.0, 0.3)))
    assert listed(base) == {
        "coulomb_friction": [0.8, 1.5, 0.5],
        "viscous_friction": [0.6, 0.0, 0.3],
    }


def test_friction_of_mjcf_is_read_by_its_defaults_and_on_axes_that_slide(tmp_path: Path) -> None:
    text = CART.replace("<worldbody>", '<default><joint damping="0.4"/></default><worldbody>')
    text = text.replace('name="rail"', 'name="rail" frictionloss="7"')
    (tmp_path / "cart.xml").write_text(text)
    (tmp_path / "cart.toml").write_text(
        'robot = "cart.xml"\n' + ENTRY.format("quadratic_drag", 1, "D_2 = 0.5")
        + ENTRY.format("torque_offset", 1, 'o = { value = 3, unit = "N" }')
    )  # fmt: skip
    assert listed(base_for(tmp_path / "cart.toml")) == {
        "quadratic_drag": [0.5, 0.0, 0.0],
        "torque_offset": [3.0, 0.0, 0.0],
        "coulomb_friction": [7.0, 0.0, 0.0],
        "viscous_friction": [0.4, 0.4, 0.4],
    }


@pytest.mark.parametrize(
    ("id", "values"), [("coulomb_friction", "F_c = 2\ns_0 = 0.05"),
                       ("stribeck_friction", "F_c = 2\nF_s = 1\ns_0 = 0.001\nv_s = 0.02")]
)  # fmt: skip
def test_what_the_toml_says_of_an_axis_stands_in_the_place_of_the_file(
    id: str, values: str, tmp_path: Path
) -> None:
    found = listed(base_for(arm(tmp_path, more=ENTRY.format(id, 2, values))))
    assert found[id][1] == 2.0
    others = found["coulomb_friction"]
    assert (others[0], others[2]) == (0.8, 0.5)
    assert others[1] == (2.0 if id == "coulomb_friction" else 0.0)


WRONG = {
    "axis": (ENTRY.format("torque_offset", 4, "o = 1"), "effects.1: axes: 4, the logs have 1 to 3"),
    "id": (ENTRY.format("coulomb", 1, "F_c = 1"), "effects.1: there is no effect 'coulomb', did"),
    "gain": (ENTRY.format("coulomb_friction", 1, "s_0 = 1e-3"), "parameters.F_c: is missing"),
    "unit": (
        ENTRY.format("torque_offset", 1, 'o = { value = 1, unit = "mN m" }'),
        "parameters.o: is in 'mN m', wanted 'N m': convert",
    ),
    "negative": (
        ENTRY.format("coulomb_friction", 1, "F_c = -1\ns_0 = 1e-3"),
        "F_c: -1.0 N m, must be at least 0",
    ),
    "nan": (ENTRY.format("torque_offset", 1, "o = nan"), "o: nan is not a finite number"),
    "width": (
        ENTRY.format("coulomb_friction", 1, "F_c = 1\ns_0 = 0"),
        "s_0: 0.0 rad, must be above 0",
    ),
    "count": (ENTRY.format("torque_offset", "1, 2", "o = [1, 2, 3]"), "o: wants 2 entries, has 3"),
    "encoder": (
        ENTRY.format("encoder_eccentricity", 1, "e_c = 1e-3\ne_s = 0\nk = 1"),
        "effects.1: encoder_eccentricity is no torque that goes with the motion: take it out",
    ),
    "twice": (
        ENTRY.format("torque_offset", 2, "o = 1") + ENTRY.format("torque_offset", "1, 2", "o = 2"),
        "effects.2: axis 2 has torque_offset already: write one entry with the sum",
    ),
    "both frictions": (
        ENTRY.format("stribeck_friction", 1, "F_c = 1\nF_s = 1\ns_0 = 1e-3\nv_s = 0.1")
        + ENTRY.format("coulomb_friction", 1, "F_c = 1\ns_0 = 1e-3"),
        "effects.2: axis 1 has stribeck_friction already",
    ),
    "limit": (
        ENTRY.format("torque_saturation", 1, "clip = 1\ntau_lim = 3\np = 16"),
        "effects.1: torque_saturation is no torque that goes with the motion: take it out",
    ),
    "lag": (ENTRY.format("drive_lag", 1, "T_lag = 1e-3"), "effects.1: drive_lag is no torque that"),
    "source": (
        ENTRY.format("cross_coupling", 1, "C = 1\nsource = 1\nkind = 0"),
        "effects.1: axis 1 can have no cross_coupling with these values",
    ),
    "no text": (
        ENTRY.format("x", 1, "o = 1").replace('"x"', '["a"]'),
        "effects.1: there is no effect",
    ),
    "no id": (
        ENTRY.format("x", 1, "o = 1").replace('id = "x"\n', ""),
        'effects.1: id: is missing: add id = "coulomb_friction"',
    ),
    "joint": (
        ENTRY.format("torque_offset", '"elbo"', "o = 1"),
        "axes: elbo is no axis: is it elbow",
    ),
    "case": (
        ENTRY.format("coulomb_friction", 1, "F_C = 1\ns_0 = 1e-3"),
        "parameters.F_C: coulomb_friction has only F_c",
    ),
    "one": ("[effects]\nid = 'x'\n", r"effects: wants a list of tables: write \[\[effects\]\]"),
    "gravity": ("gravity = [0, 0, 9810]\n", "gravity is 9810 m/s2: on the earth it is 9.81"),
    "share": (
        ENTRY.format("load_friction", 1, "mu = 5\ns_0 = 1e-3"),
        "mu: 5.0, must be at most 0.5",
    ),
    "table": ('effects = "friction"\n', "effects: wants a list, is 'friction'"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_entry_is_an_error_with_its_place(name: str, tmp_path: Path) -> None:
    text, message = WRONG[name]
    with pytest.raises(MachineError, match=f"arm.toml: .*{message}"):
        base_for(arm(tmp_path, more=text))


@pytest.mark.parametrize("text", ["-0.3", "nan", "", "inf", "much"])
def test_friction_that_no_joint_has_is_an_error(text: str, tmp_path: Path) -> None:
    with pytest.raises(MachineError, match=f"joint elbow has damping='{text}': a number, not"):
        base_for(arm(tmp_path, viscous=(0.6, 0.9, text)))
    arm(tmp_path)
    file = tmp_path / "arm.urdf"
    file.write_text(file.read_text().replace("damping", "dampning", 1))
    with pytest.raises(MachineError, match="column: <dynamics> has no dampning: is it damping"):
        base_for(file)
    cart = CART.replace('name="rail"', f'name="rail" armature="{text}"')
    (tmp_path / "cart.xml").write_text(cart)
    with pytest.raises(MachineError, match=f"joint rail has armature='{text}'"):
        base_for(tmp_path / "cart.xml")


def test_friction_of_a_default_is_looked_at(tmp_path: Path) -> None:
    text = CART.replace("<worldbody>", '<default><joint damping="-0.4"/></default><worldbody>')
    (tmp_path / "cart.xml").write_text(text)
    with pytest.raises(MachineError, match=r"joint <default> has damping='-0\.4'"):
        base_for(tmp_path / "cart.xml")


def test_axes_may_be_called_by_their_joints(tmp_path: Path) -> None:
    entry = ENTRY.format("torque_offset", '"elbow", 1', "o = [3, 1]")
    assert listed(base_for(arm(tmp_path, more=entry)))["torque_offset"] == [1.0, 0.0, 3.0]


def test_heavy_axes_have_what_friction_they_have(tmp_path: Path) -> None:
    """Also two waves on one axis."""
    waves = [ENTRY.format("cogging_harmonic", 1, f"a = 0\nb = 2e5\norder = {n}") for n in (11, 18)]
    base = base_for(arm(tmp_path, viscous=(2e5, 0, 0), more="".join(waves)))
    assert listed(base)["viscous_friction"] == [2e5, 0.0, 0.0]


def test_friction_of_an_sdf_is_read_without_springs(tmp_path: Path) -> None:
    link = "<link name='{}'><inertial><mass>2</mass><inertia><ixx>.1</ixx><iyy>.1</iyy><izz>.1"
    link += "</izz><ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial></link>"
    joint = "<joint name='j' type='revolute'><parent>foot</parent><child>arm</child><axis><xyz>0 1"
    joint += " 0</xyz><limit><lower>-3</lower><upper>3</upper></limit><dynamics><damping>0.7"
    joint += "</damping></dynamics></axis></joint>"
    fixed = "<joint name='w' type='fixed'><parent>world</parent><child>foot</child></joint>"
    links = link.format("foot") + link.format("arm")
    text = f"<sdf version='1.7'><model name='m'>{fixed}{links}{joint}</model></sdf>"
    (tmp_path / "arm.sdf").write_text(text)
    assert listed(base_for(tmp_path / "arm.sdf", 1)) == {"viscous_friction": [0.7]}


def test_axes_that_turn_and_slide_want_entries_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "cart.xml").write_text(CART)
    text = ENTRY.format("torque_offset", "1, 2", "o = 1")
    (tmp_path / "cart.toml").write_text(f'robot = "cart.xml"\n{text}')
    with pytest.raises(MachineError, match=r"effects\.1: axes 1 and 2: some turn, some slide"):
        base_for(tmp_path / "cart.toml")


def test_what_is_as_the_files_say_is_no_finding(tmp_path: Path) -> None:
    """All that the arm has is stated: friction in its file, the ripple beside it."""
    ripple = ENTRY.format("cogging_harmonic", 3, f"a = 0\nb = {RIPPLE}\norder = {PER_TURN}")
    found = flexhex.diagnose_runs(RUNS, HELD_OUT, base=str(arm(tmp_path, more=ripple)))
    assert (found.verdict, found.effects, found.changed) == ("none", (), ())
    said = [note for note in found.notes if note.startswith("as the robot's files say")]
    assert len(said) == 1
    for title in ("Coulomb friction on axes 1, 2 and 3", "cogging harmonic on axis 3"):
        assert title in said[0]
    # nothing was added
    assert_close(found.residual.after, found.residual.before, rtol=0)


def test_other_values_than_the_files_are_changes_and_the_rest_is_missing(tmp_path: Path) -> None:
    """Half of the friction of axis 1, thrice the damping of axis 2, a ripple that axis 1 has not;
    that of axis 3 is missing."""
    ripple = ENTRY.format("cogging_harmonic", 1, "a = 0\nb = 0.3\norder = 11")
    base = arm(tmp_path, (0.4, 1.5, 0.5), (0.6, 2.7, 0.3), ripple)
    found = flexhex.diagnose_runs(RUNS, HELD_OUT, base=str(base))
    assert [(e.id, e.axes) for e in found.effects] == [("cogging_harmonic", (3,))]
    changed = {c.parameter: c for c in found.changed}
    assert changed.keys() == {"F_c[1]", "d[2]", "cogging_harmonic.b[1]"}
    truth = {"F_c[1]": DRY[0], "d[2]": VISCOUS[1], "cogging_harmonic.b[1]": 0.0}
    for name, value in truth.items():
        low, high = changed[name].estimate.ci95
        assert low <= value <= high
    assert changed["d[2]"].nominal == 2.7

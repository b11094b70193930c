"""Effects that a robot's files state: read, compared with the runs, written by `identify`.

The logs are those of `examples/robot`, which MuJoCo made; what is true of them stands there.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import flexhex
from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.logs import Log
from flexhex.fmus.common.errors import MachineError
from tests.compare import assert_close
from tests.conftest import ROOT
from tests.diagnosis.estimation.machines import CART

pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
Array = NDArray[np.float64]
EXAMPLE = ROOT / "examples" / "robot"
RUNS = tuple(EXAMPLE / f"{name}.csv" for name in ("a1", "a2", "b1", "b2"))
HELD_OUT = (EXAMPLE / "c1.csv",)
DRY, VISCOUS, RIPPLE, PER_TURN = (0.8, 1.5, 0.5), (0.6, 0.9, 0.3), 0.25, 18
ENTRY = """[[effects]]
id = "{}"
axes = [{}]
[effects.parameters]
{}
"""


def arm(folder: Path, dry: Any = DRY, viscous: Any = VISCOUS, more: str = "") -> Path:
    """The example's arm with friction in its file, and a TOML beside it."""
    text = (EXAMPLE / "arm.urdf").read_text()
    for joint, friction, damping in zip(("column", "shoulder", "elbow"), dry, viscous, strict=True):
        head, name, rest = text.partition(f'<joint name="{joint}"')
        end = rest.index("</joint>")
        tag = f'<dynamics damping="{damping}" friction="{friction}"/>'
        text = head + name + rest[:end] + tag + rest[end:]
    (folder / "arm.urdf").write_text(text)
    beside = folder / "arm.toml"
    beside.write_text(f'robot = "arm.urdf"\n{more}')
    return beside


def base_for(file: Path, n: int = 3) -> RobotBase:
    base = base_of(str(file), None, Log.of("run.csv", 0.01, *np.zeros((2, 20, n))))
    assert isinstance(base, RobotBase)
    return base


def listed(base: RobotBase) -> dict[str, list[float]]:
    """First gain of each effect on each axis, 0 where there is none."""
    values = dict[str, list[float]]()
    for use in base.stated.uses:
        own = values.setdefault(use.id, [0.0] * base.n)
        for axis, gain in zip(use.axes, use.gains[0], strict=True):
            own[axis - 1] += gain
    return values


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
        "effects.1: encoder_eccentricity is no torque of the motion: take it out",
    ),
    "table": ('effects = "friction"\n', "effects: wants a list, is 'friction'"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_entry_is_an_error_with_its_place(name: str, tmp_path: Path) -> None:
    text, message = WRONG[name]
    with pytest.raises(MachineError, match=f"arm.toml: .*{message}"):
        base_for(arm(tmp_path, more=text))


def test_friction_below_zero_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(MachineError, match=r"joint elbow has a damping of -0\.3: correct it"):
        base_for(arm(tmp_path, viscous=(0.6, 0.9, -0.3)))


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


def test_a_base_that_would_be_overwritten_is_refused(tmp_path: Path) -> None:
    from flexhex.fmus.common.errors import UsageError
    from flexhex.identify.write_other import checked_target

    file = arm(tmp_path)
    (tmp_path / "arm.urdf").rename(tmp_path / "other.urdf")
    file.write_text('robot = "other.urdf"\n')
    with pytest.raises(UsageError, match=r"arm.urdf: .*arm.toml would be overwritten, too"):
        checked_target(tmp_path / "arm.urdf", str(file))


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

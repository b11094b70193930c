"""Adding what was found: a machine file beside the user's own, which stays as it was."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from diagnosis.verdict import Estimate, Named
from flexhex.diagnose_apply import add, added, extended
from fmus.common.errors import MachineError
from fmus.common.machine_file import load_machine, truth_file
from tests.conftest import MACHINE_FILE
from tests.flexhex.diagnoses import BASIC, CHANGED, PAYLOAD, coulomb, estimate

BUILT: list[Path] = []


@pytest.fixture(autouse=True)
def _not_built(monkeypatch: pytest.MonkeyPatch) -> None:
    """Building takes minutes and is tested elsewhere: only what would be built is noted."""
    BUILT.clear()
    monkeypatch.setattr("flexhex.build.Builder.systems", lambda self: BUILT.append(self.out))


def two_axes() -> Named:
    """Coulomb friction on axes 2 and 4, each with estimates of its own."""
    parts = tuple(
        (axis, {"F_c": estimate(0.05 + 0.01 * axis, 0.003), "v0": estimate(0.002, 0.0, "rad/s")})
        for axis in (2, 4)
    )
    return replace(coulomb((2, 4)), parts=parts)


def test_machine_file_has_what_was_found_and_all_it_had(tmp_path: Path) -> None:
    before = MACHINE_FILE.read_bytes()
    done = add(replace(BASIC, effects=(two_axes(),)), MACHINE_FILE, tmp_path)
    assert done.machine == str(tmp_path / "tflex-extended.toml")
    machine, plain = load_machine(done.machine), load_machine(MACHINE_FILE)
    assert [(u.id, u.axes, u.gains, u.shapes) for u in machine.effects] == [
        ("coulomb_friction", (2,), ((0.07,),), (0.002,)),
        ("coulomb_friction", (4,), ((0.09,),), (0.002,)),
    ]
    assert machine.model_copy(update={"effects": ()}) == plain
    assert MACHINE_FILE.read_bytes() == before
    assert [tmp_path] == BUILT


def test_extended_file_shares_the_truth_and_can_be_extended_again(tmp_path: Path) -> None:
    first = Path(str(add(BASIC, MACHINE_FILE, tmp_path / "one").machine))
    other = Named("drive_lag", "", (1,), {"T_lag": estimate(2e-4, 1e-5, "s")})
    second = Path(str(add(replace(BASIC, effects=(other,)), first, tmp_path / "two").machine))
    assert [use.id for use in load_machine(second).effects] == ["coulomb_friction", "drive_lag"]
    assert truth_file(second).resolve() == truth_file(MACHINE_FILE).resolve()


def test_estimates_keep_their_intervals_and_a_shape_without_one_is_assumed() -> None:
    (entry,) = added(coulomb())
    assert entry["axes"] == [3]
    assert entry["parameters"]["F_c"]["ci95"] == pytest.approx([0.0469, 0.0531])
    assert entry["parameters"]["F_c"]["source"] == "diagnosed"
    wanted = {"value": 0.002, "unit": "rad/s", "source": "assumed"}
    assert entry["parameters"]["v0"] == wanted


def test_effect_of_the_whole_machine_has_no_axes(tmp_path: Path) -> None:
    tilt = {name: Estimate(0.003, (0.002, 0.004), "rad") for name in ("tilt_x", "tilt_y")}
    effect = Named("gravity_tilt", "", (), tilt, ((0, tilt),))
    (use,) = load_machine(
        str(add(replace(BASIC, effects=(effect,)), MACHINE_FILE, tmp_path).machine)
    ).effects
    assert (use.axes, use.gains) == ((), ((0.003,), (0.003,)))


def test_changed_parameters_are_left_to_the_user_and_said(tmp_path: Path) -> None:
    done = add(CHANGED, MACHINE_FILE, tmp_path)
    assert (done.machine, BUILT) == (None, [])
    assert done.notes[-1] == "end_effector.m: write the new values into tflex.toml by hand"
    both = add(replace(BASIC, changed=(PAYLOAD,)), MACHINE_FILE, tmp_path)
    assert both.machine is not None
    assert "by hand" in both.notes[-1]


def test_impossible_values_are_refused_before_anything_is_built(tmp_path: Path) -> None:
    wrong = Named("coulomb_friction", "", (3,), {"F_c": estimate(-0.05, 0.01)})
    wrong = replace(wrong, parameters={**wrong.parameters, "v0": estimate(0.002, 0.0, "rad/s")})
    with pytest.raises(MachineError, match=r"tflex-extended\.toml: effects\.1: parameters\.F_c"):
        add(replace(BASIC, effects=(wrong,)), MACHINE_FILE, tmp_path)
    assert BUILT == []


def test_machine_file_is_never_overwritten(tmp_path: Path) -> None:
    """my.toml leads to my-extended.toml, which is the very name that would be written."""
    own = tmp_path / "my-extended.toml"
    own.write_text(extended(BASIC, MACHINE_FILE, own), encoding="utf-8")
    (tmp_path / "my.toml").symlink_to(own)
    before = own.read_bytes()
    with pytest.raises(MachineError, match="would overwrite"):
        add(BASIC, tmp_path / "my.toml", tmp_path)
    assert own.read_bytes() == before

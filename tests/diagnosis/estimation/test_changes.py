"""Changed parameters of a diagnosis: they leave the file, and a payload is on its runs alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from flexhex.diagnosis.estimation.found import extras_of
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.prepare import Options
from flexhex.fmus.common.errors import UsageError
from tests.diagnosis.estimation import machines
from tests.diagnosis.estimation.test_unannounced import HEAVY


def found(*changed: dict[str, Any]) -> dict[str, Any]:
    """A diagnosis that found these changes."""
    return {"verdict": "changed", "effects": [], "changed": list(changed)}


def change(name: str, to: float, runs: tuple[str, ...] = (), was: float = 0.0) -> dict[str, Any]:
    return {"parameter": name, "from": was, "to": to, "runs": list(runs)}


def cart(folder: Path, heavy: tuple[int, ...] = ()) -> tuple[Options, list[Path]]:
    """The file of the cart, and two runs of it, of which some are of a heavier gripper."""
    file = folder / "cart.xml"
    file.write_text(machines.CART)
    models = {s: machines.heavier(HEAVY if s in heavy else machines.CART) for s in (1, 2)}
    runs = [machines.cart_runs(folder, model, (s,))[0] for s, model in models.items()]
    return Options(str(file)), runs


def test_file_counts_less_of_what_the_diagnosis_found_changed(tmp_path: Path) -> None:
    """A mass that no torque of these runs tells from its neighbours moves with the diagnosis."""
    options, runs = cart(tmp_path)
    plain = identify(runs, options=options)
    more = extras_of(found(change("arm.m", 4.5, was=3.0)), "diagnosis")
    loose = identify(runs, options=options, more=more)
    wide = [e["arm.m"].estimate.ci95[1] - e["arm.m"].estimate.ci95[0] for e in (plain, loose)]
    assert wide[1] > 1.5 * wide[0]
    assert any(note.startswith("arm.m: changed, as the diagnosis found") for note in loose.notes)
    # within its tolerance it is no news
    near = extras_of(found(change("arm.m", 3.01, was=3.0)), "diagnosis")
    assert not any("changed, as" in n for n in identify(runs, options=options, more=near).notes)


def test_payload_is_on_the_runs_that_the_diagnosis_named(tmp_path: Path) -> None:
    options, runs = cart(tmp_path, heavy=(2,))
    more = machines.heavier(HEAVY).body_mass.sum() - machines.heavier(machines.CART).body_mass.sum()
    named = (f"elsewhere/{runs[1].name}",)
    listed = found(change("payload", 0.7, named), change("payload.c_z", 0.1, named))
    identified = identify(runs, options=options, more=extras_of(listed, "diagnosis"))
    low, high = identified["payload.m"].estimate.ci95
    assert low <= more <= high
    assert identified.notes[0] == (
        "cart-2.csv: with a payload, as the diagnosis found: fitted as `payload`"
    )
    assert len([known for known in identified.parameters if known.name == "payload.m"]) == 1


@pytest.mark.parametrize(("entry", "said"), [
    (change("payload", 0.7, ("other.csv",)), "none of these runs are its runs"),
    (change("payload", 0.7, ("cart-1.csv", "cart-2.csv")), "all of these runs are its runs"),
    (change("geometry.arm.x", 0.01), "but nothing that is fitted here"),
])  # fmt: skip
def test_what_cannot_be_fitted_is_said(entry: dict[str, Any], said: str, tmp_path: Path) -> None:
    options, runs = cart(tmp_path)
    identified = identify(runs, options=options, more=extras_of(found(entry), "diagnosis"))
    assert any(said in note for note in identified.notes)
    assert "payload.m" not in {one.name for one in identified.parameters}


def test_changes_of_another_file_are_refused() -> None:
    with pytest.raises(UsageError, match="is no diagnosis"):
        extras_of(found({"parameter": "arm.m"}), "diagnosis")

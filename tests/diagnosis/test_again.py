"""A machine file with what was found, asked again about the same runs: nothing is left to find.

Both times the machine's truth file cannot be opened.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

from flexhex.diagnosis.machine_files.extend import extended_file
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.fmus.common.machine_file import load_machine, truth_file
from studies.families import FAMILIES
from tests.conftest import MACHINE_FILE
from tests.studies.test_hidden import seed_of

EFFECT = "cogging_harmonic"
OPTIONS = Options()
pytestmark = pytest.mark.slow


class Sealed:
    """While it is shut, whoever opens a truth file fails; `tried` are their names."""

    shut = False
    tried: tuple[str, ...] = ()

    @classmethod
    def watch(cls, event: str, arguments: tuple[object, ...]) -> None:
        """Called by Python before any file is opened."""
        if cls.shut and event == "open" and str(arguments[0]).endswith("-truth.toml"):
            cls.tried += (str(arguments[0]),)
            raise PermissionError(f"{arguments[0]} is sealed")


sys.addaudithook(Sealed.watch)


@dataclass(frozen=True)
class Twice:
    """The answers for a machine file and for the one that was made of the first answer."""

    first: Diagnosis
    second: Diagnosis
    extended: Path


@pytest.fixture(scope="module")
def twice() -> Twice:
    """A cogging of 3 % of torque RMS hidden by the foreign generator."""
    folder = Path(mkdtemp())
    seed = seed_of("single", EFFECT, 0.03)
    files = FAMILIES["generator"](seed, folder / "logs", folder / "sealed", None)
    Sealed.shut = True
    try:
        first = diagnose(files.paths, files.test_paths, MACHINE_FILE, OPTIONS)
        extended = extended_file(MACHINE_FILE, first, folder / "extended.toml")
        return Twice(first, diagnose(files.paths, files.test_paths, extended, OPTIONS), extended)
    finally:
        Sealed.shut = False


def test_effect_is_found_and_written(twice: Twice) -> None:
    """The generator's overtone, where it is named too, is a part of the same effect."""
    (effect,) = twice.first.effects
    assert effect.id == EFFECT
    written = load_machine(twice.extended).effects
    assert [use.id for use in written] == [EFFECT] * len(effect.parts)


def test_nobody_asked_for_the_truth(twice: Twice) -> None:
    assert Sealed.tried == ()
    assert truth_file(MACHINE_FILE).is_file(), "there must be something to be kept from"


def test_seal_is_tight() -> None:
    """The check above can fail."""
    Sealed.shut = True
    try:
        with pytest.raises(PermissionError, match="sealed"):
            truth_file(MACHINE_FILE).read_text()
    finally:
        Sealed.shut, Sealed.tried = False, ()


def test_nothing_is_named_again(twice: Twice) -> None:
    """What no effect explains is left both times, less of it the second time. The generator's
    overtone, a tenth of the cogging at twice its order, is too little to be named beside it and
    may be all there is the second time."""
    orders = [
        [values["order"].value for effect in one.effects for _, values in effect.parts]
        for one in (twice.first, twice.second)
    ]
    assert {effect.id for effect in twice.second.effects} <= {EFFECT}
    for order in orders[1]:
        assert min(abs(order / (2 * first) - 1) for first in orders[0]) < 0.01
    assert twice.second.changed == ()
    left = [np.nan_to_num(one.residual.repeatable_after) for one in (twice.first, twice.second)]
    assert np.linalg.norm(left[1]) <= np.linalg.norm(left[0])


def test_second_begins_where_the_first_ended_or_below(twice: Twice) -> None:
    """Below: the base model is fitted anew with the effect in it, widths and all."""
    axes = [axis - 1 for axis in twice.first.effects[0].axes]
    before, after = (twice.first.residual.held_out[name][axes] for name in ("before", "after"))
    again = twice.second.residual.held_out["before"][axes]
    # measured: 73 mN m, 10.4 after the first and 7.3 at the start of the second
    assert (after < 0.3 * before).all(), "the effect must be large enough to matter"
    assert (again < 1.05 * after).all()

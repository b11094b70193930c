"""Rivals of the chosen candidate, on rows whose truth is known: who is one, who is none."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from flexhex.diagnosis.rounds import one_round, search
from flexhex.diagnosis.sizes import unexplained
from tests.diagnosis.benches import ROWS, Array, Bench, bench, chosen
from tests.diagnosis.rowsets import signals


def alike(first: Array, correlation: float) -> Array:
    """A column that another explains but for 1 - correlation^2."""
    other = signals(ROWS, 1, 99)
    return correlation * first + np.sqrt(1 - correlation**2) * other


@dataclass
class Nested(Bench):
    """The effect two is one with a gain more."""

    @property
    def effects(self) -> dict[str, SimpleNamespace]:
        gains = [SimpleNamespace(low=-np.inf, high=np.inf, unit="1")]
        common = {"confused_with": (), "exact": False}
        one = SimpleNamespace(gains=gains, extends="", **common)
        two = SimpleNamespace(gains=2 * gains, extends="one", **common)
        return {
            name: SimpleNamespace(
                effect=e, shapes=len(e.gains) * [{}], searched=[], freedom=len(e.gains)
            )
            for name, e in {"one": one, "two": two}.items()
        }


@pytest.mark.parametrize(("size", "rivals"), [(0.6, ()), (0.2, ("two",))])
def test_extended_effect_is_a_rival_unless_its_extension_is_small(
    size: float, rivals: tuple[str, ...]
) -> None:
    """Unit noise in 2400 rows: the gain of a column of RMS 0.3 is known to some 0.07."""
    one = signals(ROWS, 1, 20)
    both = np.hstack([one, 0.3 * signals(ROWS, 1, 40)])
    plain = bench({("one", 0): size}, {"one": one})
    found = search(Nested(plain.made, {"one": one, "two": both}))[0].chosen
    assert found is not None
    assert (found.id, found.rivals) == ("one", rivals)


def test_column_that_is_nearly_the_true_one_is_its_rival() -> None:
    true = signals(ROWS, 1, 20)
    drawn = {"one": true, "two": alike(true, 0.97), "three": signals(ROWS, 1, 22)}
    rounds = search(bench({("one", 0): 0.6}, drawn))
    # 0.97 squared are 0.94 of the gain, more than 0.9 of it
    assert rounds[0].chosen is not None
    assert (rounds[0].chosen.id, rounds[0].chosen.rivals) == ("one", ("two",))


def test_of_effects_with_just_one_form_chance_alone_may_hide_which_it_is() -> None:
    """0.94 of the gain: of a curve that nature bends a little that is no proof, of a sine it is."""
    true = signals(ROWS, 1, 20)
    drawn = {"one": true, "two": alike(true, 0.97)}
    made = bench({("one", 0): 2.0}, drawn)
    assert [r.chosen.rivals for r in search(made) if r.chosen] == [("two",)]
    assert [r.chosen.rivals for r in search(replace(made, exact=True)) if r.chosen] == [()]
    # small beside the noise: a t-test over the clusters cannot tell
    faint = replace(bench({("one", 0): 0.25}, drawn), exact=True)
    assert [r.chosen.rivals for r in search(faint) if r.chosen] == [("two",)]


def test_rival_that_lives_on_another_effect_is_none_beside_it() -> None:
    """Of two causes the second is in the rival as well, which so explains as much as the first one
    until the second is found."""
    true, other = signals(ROWS, 1, 20), signals(ROWS, 1, 21)
    rest = signals(ROWS, 1, 22)
    drawn = {"one": true, "two": 0.72 * true + 0.48 * other + 0.5 * rest, "three": other}
    both = bench({("one", 0): 0.6, ("three", 0): 0.3}, drawn)
    rounds = search(both)
    assert chosen(rounds) == [("one", (0,)), ("three", (0,))]
    first = one_round(both, both.made.regression, unexplained(both.made, both.made.regression))
    assert first.chosen is not None
    assert (first.chosen.id, first.chosen.rivals) == ("one", ("two",))
    assert [r.chosen.rivals for r in rounds if r.chosen] == [(), ()]


def test_freer_effect_that_explains_less_is_no_rival() -> None:
    true = signals(ROWS, 1, 20)
    drawn = {"one": true, "two": alike(true, 0.97), "three": signals(ROWS, 1, 22)}
    made = replace(bench({("one", 0): 0.6}, drawn), freer=("two",))
    chosen = search(made)[0].chosen
    assert chosen is not None
    assert (chosen.id, chosen.rivals) == ("one", ())
    # the freer one wins where it is the true one, and the simpler one stays its rival
    made = replace(bench({("two", 0): 0.6}, drawn), freer=("two",))
    chosen = search(made)[0].chosen
    assert chosen is not None
    assert (chosen.id, chosen.rivals) == ("two", ("one",))


def test_freer_effect_is_judged_on_the_axes_of_the_winner() -> None:
    """On axis 2 the first one is too small to be named; the freer one explains less on axis 1."""
    true = signals(ROWS, 1, 20)
    drawn = {"one": true, "two": alike(true, 0.97), "three": signals(ROWS, 1, 22)}
    made = bench({("one", 0): 0.2, ("one", 1): 0.12, ("three", 1): 0.3}, drawn)
    made = replace(made, drawn={name: drawn[name] for name in ("one", "two")}, freer=("two",))
    made.made.torque_rms = np.array([10.0, 100.0])
    chosen = search(made)[0].chosen
    assert chosen is not None
    assert (chosen.id, chosen.axes, chosen.rivals) == ("one", (0,), ())


def test_column_that_explains_far_less_is_no_rival() -> None:
    """0.67 of the gain, less than 0.7; also where no test could tell the two apart."""
    true = signals(ROWS, 1, 20)
    drawn = {"one": true, "two": alike(true, 0.82), "three": signals(ROWS, 1, 22)}
    for size in (0.14, 0.6):
        rounds = search(bench({("one", 0): size}, drawn))
        # both pass their own tests
        assert {found.id for found in rounds[0].tried} >= {"one", "two"}
        assert rounds[0].chosen is not None
        assert (rounds[0].chosen.id, rounds[0].chosen.rivals) == ("one", ())


def test_between_the_two_a_test_from_second_to_second_decides() -> None:
    """0.86 of the gain: a rival where few rows cannot tell, none where many can."""
    true = signals(ROWS, 1, 20)
    drawn = {"one": true, "two": alike(true, 0.93), "three": signals(ROWS, 1, 22)}
    said = [search(bench({("one", 0): size}, drawn))[0].chosen for size in (0.16, 1.2)]
    assert [(f.id, f.rivals) for f in said if f] == [("one", ("two",)), ("one", ())]

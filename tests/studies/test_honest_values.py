"""The scorer's numbers: plain axes, the residual of test runs, what no machine has."""

from __future__ import annotations

import pytest

from studies.honest import score
from tests.studies.test_honest import DRAG, NONE, Data, effect, hides, rows, said, truth

PLAIN = truth(
    "plain",
    hides("coulomb_friction", [1, 2]) | {"parameters": {}},
    hides("cogging_harmonic", [1, 2])
    | {
        "observable_per_axis": [0.02, 0.02],
        "parameters": {
            "order": {"value": [12.0, 12.0], "unit": "1/rad"},
            "harmonics": {"value": [1.0, 0.5, 0.1], "unit": "1"},
        },
    },
)


def wave(*orders: float) -> Data:
    """Cogging of some orders on axis 1, and of the first one on axis 2."""
    names = ["order[1]", *(f"order[1]#{k}" for k in range(2, len(orders) + 1)), "order[2]"]
    ends = {n: (o - 0.1, o + 0.1) for n, o in zip(names, [*orders, orders[0]], strict=True)}
    return effect("cogging_harmonic", [1, 2], **ends)


def test_plain_axes_want_orders_and_harmonics_and_no_delay() -> None:
    checks = score(said("named", wave(12.02, 24.3)), PLAIN).checks
    assert checks == {
        "no delay": True,
        "order [1]": True,
        "harmonic 2 [1]": True,
        "order [2]": True,
        "harmonic 2 [2]": False,
    }
    assert not score(said("named", wave(12.6)), PLAIN).checks["order [1]"]
    late = said("ambiguous", effect("bend", [1], "time_delay"))
    assert not score(late, PLAIN).checks["no delay"]
    fitted = NONE | {"findings": ["the torque channel lags the angles by 3 ms"]}
    outcome = score(fitted, PLAIN)
    assert not outcome.checks["no delay"]
    assert rows([outcome])["plain axes", "a delay invented"] == (1, 1)


def residual(
    before: float,
    after: float,
    non_repeatable: float | None = 1.0,
    judged_on: str = "held-out runs",
) -> Data:
    """Residuals of axis 2; axis 1 has none of it."""
    other = {"before": 9.0, "after": 9.0, "non_repeatable": 1.0}
    own = {"before": before, "after": after, "non_repeatable": non_repeatable}
    return {"residual": {"judged_on": judged_on, "per_axis": {"1": other, "2": own}}}


def test_residual_is_that_of_the_named_axes_on_test_runs() -> None:
    named = said("named", effect("drag", [2]))
    assert score(named | residual(3.0, 1.2), DRAG).closed == pytest.approx(0.9)
    assert score(named | residual(3.0, 1.2, judged_on="the same runs"), DRAG).closed is None
    assert score(named | residual(1.04, 1.0), DRAG).closed is None
    assert score(NONE | residual(3.0, 3.0), DRAG).closed is None
    table = rows([score(named | residual(3.0, 1.1), DRAG), score(named | residual(3.0, 1.5), DRAG)])
    ending = "at least 90% of what the effect adds to the residual of test runs removed"
    assert table["right names", ending] == (1, 2)


def test_gap_is_what_the_effect_adds_to_the_residual_of_its_machine() -> None:
    named = said("named", effect("drag", [2]))
    twin = residual(1.5, 1.5, 1.0)["residual"]
    closed = score(named | residual(3.0, 1.8), DRAG, twin=twin).closed
    assert closed == pytest.approx((3.0 - 1.8) / (3.0 - 1.5))
    assert score(named | residual(1.55, 1.5), DRAG, twin=twin).closed is None
    # what differs between passes and was not removed is no noise
    drifting = named | residual(3.0, 1.8, 1.8)
    assert score(drifting, DRAG, twin=twin).closed == pytest.approx(0.8)


def test_one_trajectory_names_only_what_predicts_the_test_runs() -> None:
    few = DRAG | {"trajectories": ["move", "move"]}
    named = said("named", effect("drag", [2]))
    answers = [NONE, named, named | residual(3.0, 3.5), named | residual(3.0, 1.5)]
    answers.append(named | residual(3.0, 1.5, None))
    row = ("one trajectory or no repeats", "a name that does not predict the test runs")
    assert rows([score(a, few) for a in answers])[row] == (2, 5)
    assert rows([score(named, DRAG | {"passes": 1})])[row] == (1, 1)
    assert rows([score(named, DRAG)])[row] == (0, 0)


@pytest.mark.parametrize(
    ("name", "value", "impossible"),
    [
        ("link[2].m", -0.1, True),
        ("link[2].J_xx", 0.0, True),
        ("J_r[1]", -1.0, True),
        ("d[3]", -0.1, True),
        ("link[2].m", 0.1, False),
        ("link[2].mc_x", -0.1, False),
        ("o[1]", -0.1, False),
    ],
)
def test_what_no_machine_has_is_counted(name: str, value: float, impossible: bool) -> None:
    answer = {**NONE, "changed": [{"parameter": name, "to": value}]}
    assert score(answer, DRAG).impossible == impossible

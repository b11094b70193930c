"""Effects of users: the search names them where they are and not where they are not; mistakes are
named before the search."""

from __future__ import annotations

import re
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.found import extras_of
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.estimation.inverse import inverse_model, left_out
from flexhex.diagnosis.hypotheses.own_effect import own_effects
from flexhex.diagnosis.hypotheses.scales import Scales
from flexhex.diagnosis.kinds import ROTARY
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.fmus.common.errors import MachineError, UsageError
from flexhex.fmus.inverse.equations import added, signals
from tests.compare import assert_close
from tests.conftest import ROOT
from tests.diagnosis.single import SECONDS, TS, moved, wanted

Array = NDArray[np.float64]
EXAMPLE = ROOT / "flexhex" / "init" / "gas_spring.py"
FORCE, RATIO = 1.5, 1.25
"""Of the hidden spring: nothing of the grid of the example."""


def spring(theta: Array, force: float = FORCE, ratio: float = RATIO) -> Array:
    """Its torque (samples,), by its length's derivative."""
    step = 1e-6
    sides = [np.sqrt(1 + ratio**2 - 2 * ratio * np.cos(theta + s)) for s in (step, -step)]
    return np.asarray(force * (sides[0] - sides[1]) / (2 * step))


def written(folder: Path, hidden: float) -> list[Path]:
    """Two trajectories of an axis, two passes each."""
    paths, t = [], np.arange(round(SECONDS / TS)) * TS
    for seed in (1, 2):
        for number in (1, 2):
            rng, theta = np.random.default_rng([seed, number]), moved(t, seed)[0]
            tau = wanted(t, seed) + hidden * spring(theta) + 0.01 * rng.standard_normal(t.size)
            rows = np.column_stack([t, theta + 1e-6 * rng.standard_normal(t.size), tau])
            paths.append(folder / f"{seed}-{number}.csv")
            head = f"# trajectory: {seed}\n# pass: {number}\ntime,theta[1],tau_meas[1]\ns,rad,N m"
            np.savetxt(paths[-1], rows, delimiter=",", header=head, comments="", fmt="%.9g")
    return paths


def diagnosed(folder: Path, hidden: float, *effects: str) -> Diagnosis:
    return diagnose(written(folder, hidden), options=Options("axis", effects=effects))


def test_example_is_named_with_its_size_and_shape(tmp_path: Path) -> None:
    own = f"{EXAMPLE}:GasSpring"
    diagnosis = diagnosed(tmp_path, 1.0, own)
    assert [effect.id for effect in diagnosis.effects] == ["gas_spring"]
    (effect,) = diagnosis.effects
    # within the short stroke one wave of an angle looks much alike
    assert set(effect.rivals) <= {"cogging_harmonic"}
    for name, value in (("F", FORCE), ("ratio", RATIO)):
        low, high = effect.parameters[name].ci95
        assert low <= value <= high, (name, low, high)
        # an error of the form that moves the ratio moves the force with it
        assert high - low < {"F": 0.5, "ratio": 0.2}[name] * value
    assert effect.parameters["F"].unit == "N m"
    # and fitted with all other parameters
    runs, data = sorted(tmp_path.glob("*.csv")), diagnosis.data()
    extras = extras_of(data, "the diagnosis", own_effects([own]))
    identified = identify(runs, options=Options("axis"), more=extras)
    # a spring of the axis acts much like its weight on this stroke: one of them is held
    for name, value in (("F", FORCE), ("ratio", RATIO)):
        assert identified[f"gas_spring.{name}[1]"].estimate.value == pytest.approx(value, rel=0.02)
    # and compiled, with its shape as a parameter
    assert left_out(extras) == []
    model, theta = inverse_model(identified), ca.SX.sym("theta")
    p = ca.DM([one.value for one in model.parameters])
    tau = added(model, signals(theta, *ca.SX.zeros(3).elements()), ca.SX.zeros(1), p)
    at = np.linspace(-0.5, 0.5, 7)
    compiled = np.array(ca.Function("tau", [theta], [tau])(at)).ravel()
    found = {one.name: one.value for one in model.parameters}
    wanted = spring(at, found["gas_spring.F[1]"], found["gas_spring.ratio[1]"])
    assert_close(compiled, wanted, atol=1e-8)  # of the difference of the length
    (note,) = extras_of(data, "the diagnosis").notes
    assert note.endswith("if it is your own, name its file, --effect FILE.py:NAME")


def test_example_is_not_named_where_it_is_not(tmp_path: Path) -> None:
    assert diagnosed(tmp_path, 0.0, f"{EXAMPLE}:GasSpring").verdict == "none"


FEW = """import numpy as np
class Mine:
    gains = (("F", "N m"),)
    {}
    def columns(self, axis{}):
        return {}
"""
WRONG = {
    "shape": (FEW.format("pass", "", "np.ones((3, 1))"), r"shape \(3, 1\) for 12 samples and 1"),
    "finite": (FEW.format("pass", "", "np.log(0 * axis.theta - 1)"), "that of F is not finite"),
    "zero": (FEW.format("pass", "", "0 * axis.theta"), "zero for any motion"),
    "raises": (FEW.format("pass", "", "axis.angle"), r"no attribute 'angle' \(line 6\)"),
    "written": (FEW.format("pass", "", "axis.theta.sort()"), r"read-only.*line 6"),
    "misspelt": (FEW.format("shape = ()", "", "axis.theta"), "`shape`: is it `shapes`"),
    "values": (FEW.format('shapes = (("a", "m"),)', ", a", "a * axis.theta"), "values to try"),
    "taken": (FEW.format('shapes = (("a", "m", (1,)),)', "", "axis.theta"), "unexpected keyword"),
    "twice": (FEW.format('shapes = (("F", "m", (1,)),)', ", F", "axis.theta"), "listed twice"),
    "gains": (FEW.format("gains = ('F', 'N m')", "", "axis.theta"), "write a list of"),
    "on": (FEW.format("on = 0", "", "axis.theta"), "write axes from 1"),
    "most": (FEW.format("most = 0", "", "axis.theta"), "must be a whole number"),
    "members": ("class Mine:\n    gains = ()\n", "no `columns`"),
    "library": (FEW.replace("Mine", "CableForce").format("pass", "", "axis.theta"), "cable_force"),
    "name": (FEW.replace("Mine", "Yours").format("pass", "", "axis.theta"), "effect.py:Yours"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_no_effect_is_refused(case: str, tmp_path: Path) -> None:
    text, message = WRONG[case]
    file = tmp_path / "effect.py"
    file.write_text(text)
    name = "CableForce" if case == "library" else "Mine"
    with pytest.raises(MachineError, match=message):
        own_effects([f"{file}:{name}"])[name.lower()].check(1)


def test_files_that_are_not_there_and_axes_that_are_not_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"--effect .*none.py.*no such file"):
        own_effects([str(tmp_path / "none.py:Mine")])
    with pytest.raises(UsageError, match=r"FILE.py:NAME"):
        own_effects(["gas_spring"])
    with pytest.raises(UsageError, match="two effects gas_spring"):
        own_effects([f"{EXAMPLE}:GasSpring"] * 2)
    file = tmp_path / "effect.py"
    file.write_text(FEW.format("on = 2", "", "axis.theta**5"))
    with pytest.raises(MachineError, match="on: the logs have axes 1 to 1, not 2"):
        diagnosed(tmp_path, 0.0, f"{file}:Mine")


def test_columns_have_all_axes_and_one_gain_may_be_flat(tmp_path: Path) -> None:
    file = tmp_path / "effect.py"
    file.write_text(FEW.format("pass", "", "axis.others[1].theta * axis.thetad"))
    effect = own_effects([f"{file}:Mine"])["mine"]
    given = np.random.default_rng(1).standard_normal((5, 18))  # the axis, then both
    (columns,) = effect.along(given, np.zeros((5, 1)), np.zeros((5, 1)))
    assert_close(columns, (given[:, 12] * given[:, 1])[:, None], atol=0.0)


def test_values_to_try_are_taken_as_they_stand(tmp_path: Path) -> None:
    file = tmp_path / "effect.py"
    file.write_text(FEW.format('shapes = (("a", "Hz", (1, 2)),)', ", a", "a * axis.theta"))
    effect = own_effects([f"{file}:Mine"])["mine"]
    sizes, mine = ((8.0, 2.0, 2.0),), {"mine": effect}
    scales = Scales((ROTARY,), sizes, (0.0,), (1.0,), (30.0,), (8.0,), 1.0, 1.0, mine)
    assert scales.sized("mine", 0, {"a": 1.5}) == {"a": 1.5}
    assert (scales.ranges("mine", 0)["a"].low, scales.ranges("mine", 0)["a"].high) == (1.0, 2.0)


def test_guide_shows_the_example_as_it_is() -> None:
    guide = (ROOT / "docs/own-effect.md").read_text()
    (shown,) = re.findall(r"(?ms)^```python\n(.*?)^```", guide)
    assert shown == EXAMPLE.read_text()

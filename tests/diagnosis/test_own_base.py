"""Base models of users: the example finds hidden friction, mistakes are named before the search."""

from __future__ import annotations

import re
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array

from flexhex.diagnosis.basemodels.base import Motion
from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.diagnosis.workflow import Options, diagnose
from flexhex.fmus.common import user_code
from flexhex.fmus.common.errors import MachineError, UsageError
from tests.compare import assert_close
from tests.conftest import ROOT
from tests.diagnosis.two_links import BODIES, SECONDS, TS, moved, run, torque

Array = NDArray[np.float64]
EXAMPLE = ROOT / "flexhex" / "init" / "two_links.py"
FRICTION = 0.2
"""Hidden on axis 2 [N m]; its torque is 1.3 N m RMS."""
CLOCK = np.arange(round(SECONDS / TS)) * TS
HEAD = "time,theta[1],theta[2],tau_meas[1],tau_meas[2]\ns,rad,rad,N m,N m\n"


def log() -> Log:
    """A motion of two axes."""
    motion = moved(np.arange(200) * TS, 1)
    return Log.of("run.csv", TS, motion[0], torque(motion, 0.0, (0.0, 0.0)))


def written(folder: Path, seed: int, number: int, friction: float) -> Path:
    """A pass of a motion of the arm, with Coulomb friction on its second axis."""
    logged = run(seed, number, 0.0, (0.0, 0.0))
    logged["tau_meas"][:, 1] += friction * np.sign(moved(logged["time"], seed)[1][:, 1])
    rows = np.column_stack([logged["time"], logged["theta"], logged["tau_meas"]])
    path = folder / f"{seed}_{number}.csv"
    with path.open("w") as file:
        file.write(f"# trajectory: {seed}\n# pass: {number}\n{HEAD}")
        np.savetxt(file, rows, delimiter=",", fmt="%.9g")
    return path


def diagnosed(folder: Path, friction: float) -> Diagnosis:
    paths = [written(folder, seed, k, friction) for seed in (1, 2) for k in (1, 2)]
    return diagnose(paths, options=Options(base=f"{EXAMPLE}:TwoLinks"))


def test_example_has_the_torques_of_the_textbook() -> None:
    base, (theta, *rates) = base_of(f"{EXAMPLE}:TwoLinks", None, log()), moved(CLOCK, 3)
    (m, c, inertia), (m2, c2, inertia2) = BODIES
    p = np.array([m * c, inertia + m * c**2, m2, m2 * c2, inertia2 + m2 * c2**2])
    motion = Motion(0.0, TS, theta, *rates)
    wanted = torque((theta, *rates), 0.0, (0.0, 0.0))
    # torques of some 10 N m in double precision
    assert_close(base.torque(motion, p), wanted, atol=1e-12)
    assert_close(base.rows(motion, csr_array(eye_array(len(theta)))) @ p, wanted, atol=1e-12)
    known = base.linear
    assert_close([k.nominal for k in known], p, atol=min(k.tolerance for k in known))


def test_example_finds_hidden_friction(tmp_path: Path) -> None:
    diagnosis = diagnosed(tmp_path, FRICTION)
    (effect,) = [e for e in diagnosis.effects if 2 in e.axes]
    assert effect.id == "coulomb_friction"
    # near standstill noise of the angles of 2 urad blurs the sign of the rate
    assert_close(effect.parameters["F_c"].value, FRICTION, atol=0.005)


def test_example_without_friction_lacks_nothing(tmp_path: Path) -> None:
    assert diagnosed(tmp_path, 0.0).verdict == "none"


def test_guide_shows_the_example_as_it_is() -> None:
    (shown,) = re.findall(r"(?ms)^```python\n(.*?)^```", (ROOT / "docs/own-base.md").read_text())
    assert shown == EXAMPLE.read_text()


GOOD = """
import numpy as np
class Arm:
    parameters = [("J[1]", "kg m2", 0.1, 0.01), ("J[2]", "kg m2", 0.1, 0.01)]
    def columns(self, theta, thetad, thetadd):
        return thetadd[:, :, None] * np.eye(2)
"""
WRONG = {
    "syntax": (GOOD.replace("class Arm:", "class Arm"), r"base\.py: expected ':' \(line 3\)"),
    "import": ("import nonsense_\n" + GOOD, r"ModuleNotFoundError.*\(line 1\)"),
    "name": (GOOD.replace("Arm", "Leg"), r"no 'Arm' in it; it has Leg: write --base .*py:Leg"),
    "no model": ("x = 1", "no 'Arm' in it; it has no base model"),
    "called": (GOOD + "    def __init__(self, n): pass\n", "called without arguments, it fails"),
    "no columns": (GOOD.replace("def columns", "def matrix"), "no `columns`.*flexhex init"),
    "misspelt": (GOOD + "    hold = ()\n", "no member `hold`: is it `holds`?"),
    "not a list": (GOOD.replace('[("J', '"J" and 3 or [("J'), "parameters = 3: write a list"),
    "three": (GOOD.replace("0.1, 0.01), (", "0.1), ("), r"parameters\[0\].*tolerance"),
    "no number": (GOOD.replace("0.1, 0.01)]", "'a', 1)]"), r"parameters\[1\].*no numbers"),
    "negative": (GOOD.replace("0.01)]", "-1)]"), r"parameters\[1\].*at least 0"),
    "twice": (GOOD.replace("J[2]", "J[1]"), r"J\[1\] is listed twice"),
    "axis": (GOOD.replace("J[2]", "J[3]"), r"J\[3\] is of axis 3, the log has 1 to 2"),
    "axes": (GOOD + "    axes = ['rotary']\n", r"1 listed, run\.csv has 2"),
    "kinds": (GOOD + "    axes = ['round', 'linear']\n", "write a list with rotary or linear"),
    "shape": (GOOD.replace("np.eye(2)", "np.eye(2)[:, :1]"), r"shape \(8, 2, 1\).*\(8, 2, 2\)"),
    "fails": (GOOD.replace("thetadd[:, :, None]", "thetadd[9]"), r"IndexError.*\(line 6\)"),
    "written": (GOOD.replace("return", "theta[0] = 1.0; return"), "read-only"),
    "nan": (GOOD.replace("* np.eye", "* np.nan * np.eye"), r"J\[1\] on axis 1 is not finite"),
    "zero": (GOOD.replace("np.eye(2)", "(np.eye(2) / 0.0)"), r"J\[1\] on axis 1 is not finite"),
    "later": (GOOD.replace("thetadd[:", "thetadd[::-1][:"), "change with the samples after it"),
    "holds": (GOOD + "    holds = ['coulomb']\n", "no effect 'coulomb'.*coulomb_friction"),
    "payload": (GOOD + "    payload = ['m']\n", "payload: no parameter 'm'"),
    "unit": (GOOD.replace('"kg m2"', '"g"') + "    payload = ['J[1]']\n", r"J\[1\] is in g"),
    "window": (GOOD + "    window = 0\n", "window = 0: must be a time in seconds"),
}


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("case", WRONG)
def test_mistake_is_named(case: str, tmp_path: Path) -> None:
    text, message = WRONG[case]
    (tmp_path / "base.py").write_text(text)
    with pytest.raises(MachineError, match=f"(?s){message}"):
        base_of(f"{tmp_path / 'base.py'}:Arm", None, log())


def test_members_that_are_left_out_have_defaults(tmp_path: Path) -> None:
    (tmp_path / "base.py").write_text(GOOD)
    base = base_of(f"{tmp_path / 'base.py'}:Arm", None, log())
    assert (base.n, base.payload, base.holds, base.complete) == (2, (), frozenset(), False)
    assert [(known.group, known.axis) for known in base.linear] == [("J", 0), ("J", 1)]
    assert base.window == 16 * TS


def test_file_that_is_not_there_is_refused() -> None:
    with pytest.raises(UsageError, match=r"no such file gone\.py; `flexhex init gone\.py`"):
        base_of("gone.py:Arm", None, log())


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "some_package.py").write_text(GOOD)
    monkeypatch.syspath_prepend(str(tmp_path))
    listed = {
        "flexhex.bases": [
            EntryPoint(name, f"some_package:{model}", "flexhex.bases")
            for name, model in (("arm", "Arm"), ("leg", "Leg"))
        ]
    }
    monkeypatch.setattr(user_code, "entry_points", lambda group: listed[group])


@pytest.mark.usefixtures("package")
def test_package_offers_a_base_model_by_name() -> None:
    assert [known.name for known in base_of("arm", None, log()).linear] == ["J[1]", "J[2]"]
    with pytest.raises(MachineError, match=r"base model leg .*AttributeError"):
        base_of("leg", None, log())
    with pytest.raises(UsageError, match="there are hexapod, axis, arm, leg"):
        base_of("hand", None, log())

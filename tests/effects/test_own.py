"""Effects of users in machine files: the class that the diagnosis searches is in the FMUs; what
cannot be built is refused with what mends it."""

from __future__ import annotations

import re
from importlib.metadata import EntryPoint
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from flexhex.diagnosis.hypotheses.own_effect import own_effects
from flexhex.fmugen.blocks import Source
from flexhex.fmus.common import user_code
from flexhex.fmus.common.errors import MachineError, UsageError
from flexhex.fmus.common.machine_file import load_machine
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.parameters import base_parameters, parameters
from flexhex.fmus.feedforward.equations import functions
from flexhex.fmus.plant.effects import Inputs, torque
from flexhex.simulation.builder import Builder
from tests.compare import assert_close
from tests.conftest import MACHINE_FILE, ROOT
from tests.effects.machines import Array

EXAMPLE = (ROOT / "flexhex" / "init" / "gas_spring.py").read_text(encoding="utf-8")
FORCE, RATIO = 0.3, 1.25
ENTRY = f"""
[[effects]]
id = "springs.py:GasSpring"
axes = [2]
[effects.parameters]
F = {{ value = {FORCE}, unit = "N m", source = "measured" }}
ratio = {{ value = {RATIO}, unit = "1", source = "measured" }}
"""


def written(folder: Path, entry: str = ENTRY, code: str = EXAMPLE) -> Path:
    """A machine file that another one in a folder of its own extends; that file."""
    (folder / "springs.py").write_text(code, encoding="utf-8")
    base = MACHINE_FILE.read_text(encoding="utf-8") + entry
    (folder / "springy.toml").write_text(base, encoding="utf-8")
    below = folder / "below"
    below.mkdir(exist_ok=True)
    (below / "other.toml").write_text('extends = "../springy.toml"\n', encoding="utf-8")
    return below / "other.toml"


def spring(theta: Array) -> Array:
    """Its torque, by the derivative of its length."""
    step = 1e-6
    longer, shorter = (np.sqrt(1 + RATIO**2 - 2 * RATIO * np.cos(theta + s)) for s in (step, -step))
    return np.asarray(FORCE * (longer - shorter) / (2 * step))


def test_template_is_in_plant_feedforward_and_parameters(tmp_path: Path) -> None:
    machine = load_machine(written(tmp_path))
    assert [par.name for par in parameters(machine)[162:]] == ["gas_spring.F[2]"]
    rng, zero = np.random.default_rng(0), np.zeros(1)
    now, p = rng.uniform(-0.4, 0.4, 31), base_parameters(machine)
    wanted = np.zeros(6)
    wanted[1] = spring(now[1])
    (whole,) = (f for f in functions(machine) if f.name() == "feedforward_with_effects")
    added = np.array(whole(now, zero, p)).ravel() - now[18:24]
    # the oracle's difference of the length: 1e-10
    assert_close(added, wanted, atol=1e-9)
    bank = Bank.all(machine)
    theta, thetad, given = ca.SX.sym("theta", 6), ca.SX.sym("thetad", 6), Inputs.of(bank)
    taken = torque(bank, theta, thetad, given)[0]
    plant = ca.Function("taken", [theta, thetad, *given.symbols], [taken])
    values = now[:6], now[6:12], now[18:24], now[24:30], now[30], zero, np.array([FORCE])
    assert_close(np.array(plant(*values)).ravel(), wanted, atol=1e-9)


def test_another_torque_makes_other_fmus_and_another_comment_does_not(tmp_path: Path) -> None:
    machine = load_machine(path := written(tmp_path))
    key = Source("plant", machine)._key()
    assert load_machine(written(tmp_path, code=EXAMPLE + "# a comment\n")) == machine
    assert Source("plant", load_machine(path))._key() == key
    assert EXAMPLE.count("length = np.sqrt(1 +") == 1
    other = load_machine(written(tmp_path, code=EXAMPLE.replace("sqrt(1 +", "sqrt(1.001 +")))
    assert other != machine
    assert Source("plant", other)._key() != key


MINE = """import numpy as np
class Mine:
    gains = (("F", "N m", "positive"),)
    {}
    def columns(self, axis):
        return {}
"""
OWN = """
[[effects]]
id = "springs.py:Mine"
axes = [2]
[effects.parameters]
F = { value = 0.1, unit = "N m", source = "measured" }
"""
REFUSED = {
    "file": (ENTRY.replace("springs.py", "gone.py"), EXAMPLE, r"no such file .*gone\.py"),
    "name": (ENTRY.replace("GasSpring", "Spring"), EXAMPLE, r"no 'Spring' .*:GasSpring"),
    "no name": (ENTRY.replace(":GasSpring", ""), EXAMPLE, r"no name given; it has GasSpring"),
    "package": (ENTRY.replace("springs.py:", ""), EXAMPLE, r"no effect 'GasSpring'.*FILE\.py:NAME"),
    "shape": (ENTRY.replace("1.25", "5.0"), EXAMPLE, r"ratio: 5\.0, must be at most 3\.0"),
    "sign": (ENTRY.replace("0.3", "-0.3"), EXAMPLE, r"F: -0\.3 N m, must be at least 0"),
    "unit": (ENTRY.replace('"N m"', '"N"'), EXAMPLE, r"F: is in 'N', wanted 'N m'"),
    "axes": (OWN, MINE.format("on = (1, 3)", "axis.theta"), r"axes: 2, mine is for 1, 3"),
    "where": (
        OWN,
        MINE.format("pass", "np.where(axis.theta > 0, 1.0, 0.0)"),
        r"Mine: can be found, but not built: .* symbol is true \(line 6\).*np\.tanh",
    ),
    "numbers": (OWN, MINE.format("pass", "axis.theta + np.interp(axis.theta, [0, 1], [0, 1])"),
                r"can be found, but not built: .*\(line 6\)"),
    "run": (OWN, MINE.format("pass", "np.cumsum(axis.thetad)"), r"gives others than with numbers"),
    "inertia": (OWN, MINE.format("pass", "axis.thetadd ** 2"), r"linear in thetadd"),
    "typing": (OWN, MINE.format("pass", "axis.thet"), r"columns: Attribute.* 'thet' \(line 6\)"),
    "jump": (OWN, MINE.format("pass", "np.floor(axis.theta / 0.3)"),
             r"effects\.1: mine changes by .* at theta = .* smoother"),
    "steep": (OWN, MINE.format("pass", "np.tanh(axis.thetad / 1e-4)"),
              r"mine changes by 1e\+03 N m s/rad at thetad = .*, at most 784"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_built_is_one_clear_message(case: str, tmp_path: Path) -> None:
    entry, code, message = REFUSED[case]
    path = written(tmp_path, entry, code)
    with pytest.raises(MachineError) as caught:
        load_machine(path)
    assert re.search(message, str(caught.value)), str(caught.value)
    assert str(caught.value).startswith(f"{path}: effects.1: ")
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("name", ["F", "ratio"])
def test_unit_that_fmus_do_not_have_is_said_with_the_file(name: str, tmp_path: Path) -> None:
    unit = {"F": "N m", "ratio": "1"}[name]
    other, code = ENTRY, EXAMPLE.replace(f'("{name}", "{unit}"', f'("{name}", "furlong"')
    for line in ENTRY.splitlines():
        if line.startswith(name):
            other = ENTRY.replace(line, line.replace(f'"{unit}"', '"furlong"'))
    path = written(tmp_path, other, code)
    with pytest.raises(MachineError) as caught:
        Builder(path, tmp_path / "out").check()
    assert str(caught.value).startswith(
        f"{path}: effects: gas_spring.{name}: unknown unit 'furlong', known: "
    )


def test_friction_that_the_steps_follow_is_taken(tmp_path: Path) -> None:
    """What is refused as steep is not all friction."""
    code = MINE.format("pass", "np.tanh(axis.thetad / 2e-4)")
    (use,) = load_machine(written(tmp_path, OWN, code)).effects
    assert use.id == "mine"


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An installed package that offers an effect, and one that it does not hold."""
    (tmp_path / "some_springs.py").write_text(EXAMPLE, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    offered = {
        "flexhex.effects": [
            EntryPoint(name, f"some_springs:{place}", "flexhex.effects")
            for name, place in (("balancer", "GasSpring"), ("lost", "Lost"))
        ]
    }
    monkeypatch.setattr(user_code, "entry_points", lambda group: offered[group])


@pytest.mark.usefixtures("package")
def test_package_offers_an_effect_by_name(tmp_path: Path) -> None:
    assert own_effects(["balancer"])["balancer"].shapes[0].name == "ratio"
    (use,) = load_machine(
        written(tmp_path, ENTRY.replace("springs.py:GasSpring", "balancer"))
    ).effects
    assert (use.id, use.gains, use.shape) == ("balancer", ((FORCE,),), {"ratio": RATIO})
    with pytest.raises(MachineError, match=r"effect lost \(some_springs:Lost\): AttributeError"):
        own_effects(["lost"])
    with pytest.raises(UsageError, match=r"--effect balance: .* offer balancer, lost: .*FILE\.py"):
        own_effects(["balance"])
    with pytest.raises(UsageError, match="cogging_harmonic: the library has it"):
        own_effects(["cogging_harmonic"])
    with pytest.raises(MachineError, match="no effect 'balancers', did you mean 'balancer'"):
        load_machine(written(tmp_path, ENTRY.replace("springs.py:GasSpring", "balancers")))

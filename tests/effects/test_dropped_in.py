"""An effect of the user's own: one file more in the library; what is no effect is refused."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import flexhex.fmus.common.effects as package
from flexhex.fmugen.blocks import build_block
from flexhex.fmus.common.effects import Effect, Experiment, Gain, check, library
from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.common.machine_file import load_machine
from flexhex.fmus.common.model.parameters import parameters
from tests.conftest import OBJECTS
from tests.effects.machines import machine_file

DROPPED_IN = '''
"""A bump in the torque at one angle."""
import casadi as ca
from flexhex.fmus.common.effects.effect import Effect, Experiment, Gain, Shape


class TorqueBump(Effect):
    """B exp(-((theta - theta_b) / 0.02)^2)."""

    id, title, acts_on = "torque_bump", "bump at one angle", "torque"
    gains = (Gain("B", "N m", 0.01, -1.0, 1.0, "height"),)
    shapes = (Shape("theta_b", "rad", -0.5, 0.5, 0.1, (0.0, 0.1), "where"),)
    excites = "slow motion through that angle"
    experiment = "slow triangle"
    spec = Experiment("triangle", {"speed": 0.05})

    def columns(self, s, state, shape):
        return ca.exp(-(((s.theta - shape["theta_b"]) / 0.02) ** 2))


EFFECT = TorqueBump()
'''


@pytest.fixture
def dropped_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder whose modules count as the library's."""
    folder = tmp_path / "more"
    folder.mkdir()
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(folder)])
    library.cache_clear()
    yield folder
    for path in folder.glob("*.py"):
        sys.modules.pop(f"{package.__name__}.{path.stem}", None)
    monkeypatch.undo()
    library.cache_clear()


def test_user_adds_an_effect_by_one_file(dropped_in: Path, tmp_path: Path) -> None:
    """From the file to FMUs that an importer accepts, with nothing else touched."""
    from fmpy.validation import validate_fmu

    (dropped_in / "bump.py").write_text(DROPPED_IN, encoding="utf-8")
    assert "torque_bump" in library()
    text = machine_file(tmp_path).read_text(encoding="utf-8")
    text += (
        '\n[[effects]]\nid = "torque_bump"\naxes = [2, 5]\n[effects.parameters]\n'
        'B = { value = [0.02, 0.03], unit = "N m", source = "diagnosed" }\n'
        'theta_b = { value = 0.1, unit = "rad", source = "assumed" }\n'
    )
    (tmp_path / "bumpy.toml").write_text(text, encoding="utf-8")
    bumpy = load_machine(tmp_path / "bumpy.toml")
    assert [p.name for p in parameters(bumpy)[162:]] == ["torque_bump.B[2]", "torque_bump.B[5]"]
    for block in ("filter", "feedforward"):
        assert not validate_fmu(str(build_block(block, bumpy, tmp_path, cache=OBJECTS)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ('id, title, acts_on = "coulomb_friction", "again", "torque"', "exists twice"),
        ('id, title, acts_on = "torque_bump", "", "torque"', "sets no title"),
    ],
)
def test_library_refuses_what_is_no_effect(dropped_in: Path, change: str, message: str) -> None:
    first = 'id, title, acts_on = "torque_bump", "bump at one angle", "torque"'
    assert first in DROPPED_IN
    (dropped_in / "zz_bump.py").write_text(DROPPED_IN.replace(first, change), encoding="utf-8")
    with pytest.raises(MachineError, match=message):
        library()


@pytest.mark.parametrize(
    ("gain", "message"),
    [
        (Gain("B", "N m", 0.01, 0.5, 1.0), "low <= 0"),
        (Gain("B", "N m", 2.0, 0.0, 1.0), "typical <= high"),
    ],
)
def test_library_refuses_gains_that_cannot_be_absent(gain: Gain, message: str) -> None:
    class Wrong(Effect):
        id, title, acts_on = "wrong", "wrong", "torque"
        gains = (gain,)
        excites = experiment = "nothing"
        spec = Experiment("random")

    with pytest.raises(MachineError, match=message):
        check(Wrong(), where="wrong")

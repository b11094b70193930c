"""The call table of the standard holds for every function of every FMU, in every state."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexhex.fmugen.blocks import BLOCKS
from tests.adapter.slave import DISCARD, ERROR, OK, Binary, Slave
from tests.adapter.test_calls import STATES, TABLE, arguments, bring


@pytest.mark.parametrize("name", [*BLOCKS, "machine"])
def test_every_function_in_every_state(fmu_dir: Path, tmp_path: Path, name: str) -> None:
    binary = Binary(fmu_dir / f"{name}.fmu", tmp_path)
    wrong = []
    for function, letters in TABLE.items():
        for state, letter in zip(STATES, letters, strict=True):
            slave = bring(Slave(binary), state)
            given = arguments(function, slave)
            if function in ("fmi2GetReal", "fmi2SetReal"):
                # Ts can be set until the initialisation is left, tunables and inputs after it too
                given = (None, given[1].__class__(0), None)
            status, said = slave.call(function, *given), slave.said
            good = DISCARD if function == "fmi2GetIntegerStatus" else OK
            legal = letter == "x"
            message = f"{function} is not allowed in state {state} (instance one)"
            if status != (good if legal else ERROR) or (not legal and said != message):
                wrong.append((function, state, status, said))
            slave.free()
    assert wrong == []

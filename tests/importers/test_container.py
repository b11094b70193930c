"""The container keeps the timing rule and the rules of refusal: toys that show each step."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave

from flexhex.export.container import container_of
from flexhex.fmugen.container import build_container
from flexhex.fmugen.container_parts import Link
from flexhex.fmugen.container_table import parts_header
from flexhex.fmus.common.errors import InterfaceError
from flexhex.ssp.read import read_ssp
from tests.conftest import OBJECTS
from tests.importers.loop import BASE
from tests.ssp import toys
from tests.typed import outputs_of, values_of

RELAYS = ("a", "a2", "b", "c")
SHOWN = [f"{name}.y" for name in RELAYS]


def contained(
    limit: float, folder: Path, n_steps: int
) -> tuple[dict[str, np.ndarray], toys.System]:
    """Run the ring's relays as one FMU, fed with the source's own history.

    Row k of a variable is what is seen at base step k + 1.
    """
    system = toys.ring(limit)
    package = read_ssp(toys.pack(system, folder))
    path = build_container(container_of(package, ("src",), SHOWN), folder / "one", OBJECTS)
    description, unpacked = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=unpacked,
        modelIdentifier="controller",
        instanceName="relays",
    )
    names = {v.name: v.valueReference for v in description.modelVariables}
    outputs = outputs_of(description)
    source = toys.jacobi(toys.ring(), n_steps)["src"]
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    rows = []
    for n in range(n_steps):
        fmu.setReal([names["r[1]"], names["r[2]"]], list(source[n]))
        fmu.doStep(currentCommunicationPoint=n * BASE, communicationStepSize=BASE)
        rows.append(values_of(fmu, outputs))
    fmu.terminate()
    fmu.freeInstance()
    return dict(zip([v.name for v in outputs], np.array(rows).T, strict=True)), system


def test_container_equals_its_parts_stepped_by_themselves(tmp_path: Path) -> None:
    """Against plain Python under the timing rule; periods 1, 1, 2, 120 in a ring."""
    result, system = contained(1e6, tmp_path, 1200)
    expected = toys.jacobi(system, 1200)
    for name in RELAYS:
        for k in (1, 2):
            theirs = np.array(expected[name])[1:, k - 1]
            assert result[f"{name}_y[{k}]"].tobytes() == theirs.tobytes(), name
            assert np.ptp(theirs) > 0.1, f"{name} rests: nothing was shown"
    assert not result["fault"].any()


def test_part_that_is_fed_out_of_range_keeps_its_inputs_and_reports_a_fault(tmp_path: Path) -> None:
    """c, of period 4, allows stamps up to 40. Its tick at 48 is fed 44: from 52 on its fault
    is 1 and it hands on the stamp of 40, while the others go on."""
    result, _ = contained(40.0, tmp_path, 80)
    seen = np.arange(1, 81)
    np.testing.assert_array_equal(result["c_fault"], (seen >= 52).astype(float))
    np.testing.assert_array_equal(result["fault"], result["c_fault"])
    assert result["c_y[1]"][-1] == result["c_y[1]"][50] == 40.0
    assert result["b_y[1]"][-1] > 70.0


def test_input_that_nothing_feeds_is_refused(tmp_path: Path) -> None:
    package = read_ssp(toys.pack(toys.ring(), tmp_path))
    whole = container_of(package, ("src",), SHOWN)
    broken = type(whole)(
        whole.parts,
        tuple(link for link in whole.links if link != Link("b", "y[2]", "a2", "v")),
        whole.inputs,
        whole.outputs,
        whole.description,
        whole.base,
    )
    sizes = {part.interface.name: 2 for part in whole.parts}
    assert "N_PARTS = 4" in parts_header(whole, sizes)
    with pytest.raises(InterfaceError, match=r"a2\.v: fed by nothing in the container"):
        parts_header(broken, sizes)

"""The whole controller as one FMU: the same bits as its parts, in the loop and elsewhere."""

from __future__ import annotations

import re
import subprocess
import zipfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

from flexhex.export.container import container_of, export_container
from flexhex.fmugen.compile import compiler
from flexhex.fmus.common.errors import InterfaceError, RunError
from flexhex.ssp.executor import run
from flexhex.ssp.read import read_ssp
from flexhex.ssp.results import Result
from tests.conftest import ROOT, one_at_a_time
from tests.importers.loop import BASE, SECONDS
from tests.typed import values_of

OUTPUTS = [f"tau[{k}]" for k in range(1, 7)] + [
    "feedback_e[1]",
    "K_p.actuator[1].d",
    "W_fault",
    "fault",
]


@pytest.fixture(scope="session")
def controller_ssp(loop_ssp: Path) -> Path:
    """Reference, controller.fmu, plant; controller.fmu stands beside it."""
    out = loop_ssp.parent / "export"
    with one_at_a_time(out):
        return export_container(loop_ssp, out)[-1]


@pytest.fixture(scope="session")
def single(loop_ssp: Path) -> Result:
    """The loop with all FMUs by themselves."""
    parts = ["plant", "feedback", "K", "F.tau_ff", "W.fault", "N_F", "N_E"]
    return run(loop_ssp, SECONDS, signals=parts)


@pytest.fixture
def slave(controller_ssp: Path) -> Iterator[FMU2Slave]:
    """controller.fmu, instantiated by FMPy."""
    path = controller_ssp.parent / "controller.fmu"
    description, folder = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="controller",
    )
    fmu.instantiate()
    fmu.variables = {v.name: v for v in description.modelVariables}
    fmu.names = {name: v.valueReference for name, v in fmu.variables.items()}
    yield fmu
    fmu.freeInstance()


def test_guide_lists_the_lines_between_the_blocks(controller_ssp: Path) -> None:
    """The table of docs/import.md, by which they are drawn by hand in Simulink."""
    text = (ROOT / "docs" / "import.md").read_text(encoding="utf-8")
    cells = r"\| (\w+) `(\w+)[^|]*\| (\w+) `(\w+)[^|]*\| (\d+) \|"
    rows = re.findall(cells, text.partition("### Simulink")[2])
    listed = {tuple(row[:4]): int(row[4]) for row in rows}
    drawn = Counter(
        tuple(end.partition("[")[0] for end in wire) for wire in read_ssp(controller_ssp).wires
    )
    # the setpoint with its rates is one row
    rates = [drawn.pop(("reference", rate, "controller", rate)) for rate in ("rd", "rdd")]
    drawn["reference", "r", "controller", "r"] += sum(rates)
    assert listed == drawn


def initialised(fmu: FMU2Slave) -> FMU2Slave:
    """Ready for its first step."""
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu


def stepped(fmu: FMU2Slave, steps: range) -> list[list[float]]:
    """Outputs after each step, fed with waves."""
    inputs = [fmu.names[f"theta[{k}]"] for k in range(1, 7)]
    outputs = [fmu.variables[name] for name in OUTPUTS]
    rows = []
    for n in steps:
        fmu.setReal(inputs, [1e-4 * np.sin(0.01 * n + k) for k in range(6)])
        fmu.doStep(currentCommunicationPoint=n * BASE, communicationStepSize=BASE)
        rows.append(values_of(fmu, outputs))
    return rows


def test_controller_in_the_loop_gives_the_same_bits(controller_ssp: Path, single: Result) -> None:
    """At every base step; slow parts show through the container what they hold."""
    shown = ["plant", "controller"]
    together = run(controller_ssp, SECONDS, signals=shown)
    pairs = {
        "plant.theta": "plant.theta",
        "plant.tau_meas": "plant.tau_meas",
        "feedback.tau": "controller.tau",
        "feedback.e": "controller.feedback_e",
        "F.tau_ff": "controller.F_tau_ff",
        "K.p": "controller.K_p",
        "K.p_std": "controller.K_p_std",
        "N_E.residual": "controller.N_E_residual",
    }
    for alone, inside in pairs.items():
        group = single.group(alone)
        theirs = together[inside]
        places = np.arange(len(theirs)) // group.period
        assert theirs.tobytes() == single[alone][places].tobytes(), inside
    assert np.ptp(together["plant.theta"], axis=0).min() > 0.01, "the loop rests"
    assert np.ptp(together["controller.K_p"], axis=0).max() > 0.01, "nothing adapts"
    assert not together["controller.fault"].any()


def test_container_is_a_valid_fmu_that_builds_from_its_sources(
    controller_ssp: Path, tmp_path: Path
) -> None:
    path = controller_ssp.parent / "controller.fmu"
    assert validate_fmu(str(path)) == []
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    sources = sorted((tmp_path / "sources").glob("*.c"))
    call = [*compiler(), "-std=c99", "-shared", "-fPIC", "-o", str(tmp_path / "c.so")]
    subprocess.run([*call, *map(str, sources), "-lm"], check=True)


@pytest.mark.slow
def test_container_links_into_one_program_with_its_parts(
    controller_ssp: Path, loop_ssp: Path, tmp_path: Path
) -> None:
    """As TwinCAT and Simulink Real-Time need it: no name is defined twice."""
    with zipfile.ZipFile(loop_ssp) as archive:
        archive.extractall(tmp_path, [n for n in archive.namelist() if n.endswith(".fmu")])
    fmus = [controller_ssp.parent / "controller.fmu", *tmp_path.glob("resources/*.fmu")]
    assert len(fmus) == 8
    objects = []
    for path in fmus:
        folder = tmp_path / path.stem
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder, [n for n in archive.namelist() if n.startswith("sources/")])
        names = sorted(p.name for p in (folder / "sources").glob("*.c"))
        call = [*compiler(), "-std=c99", "-O0", "-c", "-fPIC", "-DFLEXHEX_STATIC", *names]
        subprocess.run(call, cwd=folder / "sources", check=True)
        objects += [str(folder / "sources" / n.replace(".c", ".o")) for n in names]
    call = [*compiler(), "-shared", "-o", str(tmp_path / "all.so"), *objects, "-lm"]
    subprocess.run(call, check=True)


@pytest.mark.slow
def test_same_input_gives_the_same_container(controller_ssp: Path, loop_ssp: Path) -> None:
    again = export_container(loop_ssp, loop_ssp.parent / "again")[0]
    assert again.read_bytes() == (controller_ssp.parent / "controller.fmu").read_bytes()


def test_state_of_the_container_brings_every_part_back(slave: FMU2Slave) -> None:
    """Taken in the midst of the slowest part's period of 120 base steps."""
    initialised(slave)
    stepped(slave, range(307))
    kept = slave.getFMUState()
    stored = slave.serializeFMUstate(kept)
    first = stepped(slave, range(307, 907))
    slave.setFMUState(kept)
    assert stepped(slave, range(307, 907)) == first
    slave.setFMUState(slave.deSerializeFMUstate(stored))
    assert stepped(slave, range(307, 907)) == first
    slave.freeFMUState(kept)
    assert np.ptp(np.array(first)[:, 0]) > 1e-3, "nothing moved: nothing was shown"


def test_reset_container_equals_a_fresh_one(slave: FMU2Slave) -> None:
    first = stepped(initialised(slave), range(400))
    slave.reset()
    assert stepped(initialised(slave), range(400)) == first


WRONG = [
    ({"Ts": 0.0005}, r"Ts = 0\.00050*\d* s, must be the base step of 0\.000250*"),
    ({"K_Ts": 0.0301}, r"K_Ts = 0\.030\d* s, must be a whole number of base steps"),
]


@pytest.mark.parametrize(("values", "text"), WRONG, ids=[next(iter(w[0])) for w in WRONG])
def test_wrong_parameter_of_a_part_is_refused_by_name(
    controller_ssp: Path, values: dict[str, float], text: str
) -> None:
    parameters = {f"controller.{name}": value for name, value in values.items()}
    with pytest.raises(RunError, match=rf"^controller: .*{text}"):
        run(controller_ssp, 0.01, parameters=parameters)


def test_system_without_a_plant_is_refused(loop_ssp: Path, tmp_path: Path) -> None:
    package = read_ssp(loop_ssp)
    with pytest.raises(InterfaceError, match=r"hexapod.ssp: has no component 'robot'"):
        container_of(package, ("reference", "robot"))


def test_gains_may_change_while_the_controller_runs(slave: FMU2Slave) -> None:
    """As in feedback.fmu itself; what its start prepares may not."""
    fmu = initialised(slave)
    gains = [fmu.names[f"feedback_kp[{k}]"] for k in range(1, 7)]
    stepped(fmu, range(60))
    assert abs(fmu.getReal([fmu.names["feedback_tau_fb[1]"]])[0]) > 1e-4
    fmu.setReal(gains, [0.0] * 6)
    stepped(fmu, range(60, 62))
    assert fmu.getReal([fmu.names["feedback_tau_fb[1]"]])[0] == 0.0
    with pytest.raises(FMICallException):
        fmu.setReal([fmu.names["feedback_tau_max"]], [1.0])


def test_inputs_are_described_as_their_sources(controller_ssp: Path) -> None:
    """`r` is no angle of an actuator, though the first part that takes it calls it so."""
    description = fmpy.read_model_description(str(controller_ssp.parent / "controller.fmu"))
    texts = {v.name: v.description for v in description.modelVariables if v.causality == "input"}
    assert texts["r[1]"] == "reference angles"
    assert texts["theta[6]"] == "actuator angles, encoder reading"

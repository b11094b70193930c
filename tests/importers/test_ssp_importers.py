"""Importers that read the .ssp as it is: the adaptive loop, 2 s, equal to the last bit."""

from __future__ import annotations

import shutil
import zipfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest
from fmpy import simulate_fmu
from fmpy.ssp.simulation import simulate_ssp

from flexhex.ssp.read import read_ssp
from tests.importers.loop import (
    BASE,
    N_STEPS,
    Rows,
    assert_same_bits,
    libcosim_rows,
    rows_of,
    wanted,
)

ECOS = "pip install ecospy; apt install libtbb12"
TOOLBOX = "pip install fmu-manipulation-toolbox"


@pytest.mark.slow
def test_fmpy_gives_the_same_bits(loop_ssp: Path, expected: Rows) -> None:
    """FMPy records after a step: row k is what is seen at base step k + 1. It stops when its
    summed time reaches the end, so half a step less gives exactly N_STEPS rows."""
    rows = simulate_ssp(str(loop_ssp), stop_time=(N_STEPS - 0.5) * BASE, step_size=BASE)
    assert_same_bits({name: rows[name] for name in expected}, expected, "FMPy")


@pytest.mark.sample(2, of="importers of the loop")
def test_libcosim_gives_the_same_bits(loop_ssp: Path, expected: Rows, tmp_path: Path) -> None:
    """The step size comes from the .ssp's own annotation, osp:FixedStepAlgorithm."""
    with zipfile.ZipFile(loop_ssp) as archive:
        archive.extractall(tmp_path)  # libcosim wants the folder that holds SystemStructure.ssd
    loaded = libcosim_rows("from_ssp_file", tmp_path, read_ssp(loop_ssp))
    assert_same_bits(loaded, expected, "libcosim")


@pytest.mark.sample(2, of="importers of the loop")
def test_ecos_gives_the_same_bits(loop_ssp: Path, expected: Rows) -> None:
    """Every 60th base step: ecos hands out one value a call, by name. A difference anywhere
    would stay, since all goes round the loop."""
    wanted("ecospy", ECOS)
    from ecospy import EcosSimulation

    every, rows = 60, list[list[float]]()
    with EcosSimulation(ssp_path=str(loop_ssp), step_size=BASE) as simulation:
        simulation.init()
        names = [name.replace(".", "::", 1) for name in expected]
        for _ in range(every, N_STEPS + 1, every):
            simulation.step(every)
            rows.append([simulation.get_real(name) for name in names])
    shown = {name: values[every - 1 :: every] for name, values in expected.items()}
    assert_same_bits(rows_of(rows, list(expected)), shown, "ecos")


@pytest.mark.sample(2, of="importers of the loop")
def test_toolbox_container_gives_the_same_bits(
    loop_ssp: Path, expected: Rows, tmp_path: Path
) -> None:
    """The .ssp as one FMU; its connected signals are local variables there. The step is that of
    the FMUs' default experiments. FMPy records the start as row 0."""
    assembly = wanted("fmu_manipulation_toolbox.assembly", TOOLBOX).Assembly
    shutil.copy(loop_ssp, tmp_path / "hexapod.ssp")
    assembly(filename="hexapod.ssp", fmu_directory=tmp_path).make_fmu()
    inside = _names_inside(loop_ssp)
    names = {f"{c}.{s}": f"{inside[c]}.{s}" for c, s in (n.split(".", 1) for n in expected)}
    # in a process of its own: beside libraries that other tests loaded it was seen to abort
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        rows = pool.submit(
            simulate_fmu,
            str(tmp_path / "hexapod.fmu"),
            stop_time=N_STEPS * BASE,
            step_size=BASE,
            output_interval=BASE,
            output=list(names.values()),
        ).result()
    by_name = {ours: rows[theirs][1 : N_STEPS + 1] for ours, theirs in names.items()}
    assert_same_bits(by_name, expected, "toolbox container")


def _names_inside(path: Path) -> dict[str, str]:
    """Component -> its name in the container: the FMU's file, numbered from the second use on."""
    names: dict[str, str] = {}
    for instance in read_ssp(path).instances:
        stem = Path(instance.source).stem
        again = sum(name.partition("-")[0] == stem for name in names.values())
        names[instance.name] = f"{stem}-{again}" if again else stem
    return names

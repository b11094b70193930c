"""Importers with a wiring format of their own, written by `flexhex export --for`."""

from __future__ import annotations

import csv
import dataclasses
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from flexhex.export.wiring import WIRINGS, export_wiring, maestro
from fmus.common.errors import UsageError
from ssp.read import read_ssp
from tests.importers.loop import (
    BASE,
    N_STEPS,
    SECONDS,
    Rows,
    assert_same_bits,
    libcosim_rows,
    own_rows,
    rows_of,
    tool,
)

COFMUPY = (
    "python3 -m venv .venv-cofmupy && .venv-cofmupy/bin/pip install cofmupy==1.0.0"
    " (it pins an older FMPy), or FLEXHEX_COFMUPY=<its python>"
)
MAESTRO_JAR = "org/into-cps/maestro/maestro/2.3.0/maestro-2.3.0-jar-with-dependencies.jar"
MAESTRO = (
    "mvn dependency:get -Dtransitive=false"
    " -Dartifact=org.into-cps.maestro:maestro:2.3.0:jar:jar-with-dependencies (it needs Java 11 or"
    " newer), or FLEXHEX_MAESTRO=<the jar>"
)


def test_libcosim_gives_the_same_bits_from_its_own_format(
    loop_ssp: Path, expected: Rows, tmp_path: Path
) -> None:
    export_wiring(loop_ssp, tmp_path, "osp", SECONDS)
    package = read_ssp(loop_ssp)
    found = libcosim_rows("from_osp_config_file", tmp_path, package)
    assert_same_bits(found, expected, "libcosim, OspSystemStructure.xml")


@pytest.mark.slow
def test_cofmupy_gives_the_same_bits_with_the_reference_one_step_early(
    loop_ssp: Path, tmp_path: Path
) -> None:
    """cofmupy is a Jacobi master only inside a loop of connections: it steps the reference, which
    is in none, first, and hands its results to the others within the same step. So everybody
    sees the reference one base step (0.25 ms) early; a run whose reference starts one base step
    earlier has the same bits. Its row k, under the time before the step, is what is seen at
    base step k + 1.
    """
    python = tool("FLEXHEX_COFMUPY", ".venv-cofmupy/bin/python", COFMUPY)
    config = export_wiring(loop_ssp, tmp_path, "cofmupy", SECONDS)[-1]
    result = tmp_path / "result.npz"
    runner = Path(__file__).with_name("run_cofmupy.py")
    call = [python, str(runner), config.name, str(N_STEPS), repr(BASE), str(result)]
    done = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    early = own_rows(loop_ssp, parameters={"reference.t_start": 0.06 - BASE})
    with np.load(result) as stored:
        found = rows_of(stored["rows"], json.loads(str(stored["names"])))
    shown = {name: values for name, values in early.items() if not name.startswith("reference.")}
    assert_same_bits({name: found[name] for name in shown}, shown, "cofmupy")


@pytest.mark.slow
def test_maestro_gives_the_same_bits_with_feedback_alone(loop_ssp: Path, tmp_path: Path) -> None:
    """Reference, feedback and plant, 2 s; against a run whose feedforward counts nothing.

    Before it runs, Maestro 2.3.0 unfolds all FMUs to one program and compares its statements text
    by text: 3 FMUs took a minute, all 8 were not through after 10 min, nor was controller.fmu
    in their place after 16 min. So the adaptive loop is out of its reach.
    Its row k is what is seen at base step k. It sums its time, hence one step more is asked for.
    """
    jar = tool("FLEXHEX_MAESTRO", f"~/.m2/repository/{MAESTRO_JAR}", MAESTRO)
    package, kept = read_ssp(loop_ssp), {"reference", "feedback", "plant"}
    part = dataclasses.replace(
        package,
        instances=tuple(i for i in package.instances if i.name in kept),
        wires=tuple(w for w in package.wires if {w.source, w.target} <= kept),
    )
    config = export_wiring(loop_ssp, tmp_path, "maestro", SECONDS)[-1]
    config.write_text(maestro(part, SECONDS + BASE), encoding="utf-8")
    call = ["java", "-jar", jar, "import", "Sg1", config.name, "-fsp", ".", "-output", "out", "-i"]
    done = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, check=False)
    result = tmp_path / "out" / "outputs.csv"
    # Maestro exits with 0 whatever happens
    assert result.exists(), done.stdout[-2000:]
    with result.open(newline="") as file:
        header, *rows = list(csv.reader(file))
    names = [name.partition("}.")[2] for name in header]
    table = rows_of([[float(x) for x in row[1:]] for row in rows[1 : N_STEPS + 1]], names[1:])
    alone = own_rows(loop_ssp, parameters={"feedback.ff_gain": 0.0})
    shown = {name: alone[name] for name in alone if name in names}
    assert len(shown) >= 19, "hardly anything was compared"
    assert_same_bits({name: table[name] for name in shown}, shown, "Maestro")


@pytest.mark.parametrize("name", sorted(WIRINGS))
def test_wiring_names_every_fmu_and_connection(loop_ssp: Path, tmp_path: Path, name: str) -> None:
    *fmus, wiring = export_wiring(loop_ssp, tmp_path, name, SECONDS)
    package, text = read_ssp(loop_ssp), wiring.read_text()
    assert {f.name for f in fmus} == {Path(s).name for s in package.fmus}
    assert all(f.name in text for f in fmus)
    counted = {
        "cofmupy": lambda: len(json.loads(text)["connections"]),
        "maestro": lambda: sum(map(len, json.loads(text)["connections"].values())),
        "osp": lambda: text.count("<VariableConnection>"),
    }
    assert counted[name]() == len(package.wires)


def test_tool_without_a_format_is_refused(loop_ssp: Path, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no wiring for 'simulink', there is one for: cofmupy"):
        export_wiring(loop_ssp, tmp_path, "simulink", SECONDS)

"""Importers with a wiring format of their own, written by `flexhex export --for`."""

from __future__ import annotations

import csv
import dataclasses
import json
import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from flexhex.export.wiring import WIRINGS, export_wiring, maestro
from flexhex.fmus.common.errors import UsageError
from flexhex.ssp.read import read_ssp
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


@pytest.mark.sample(2, of="importers of the loop")
def test_libcosim_gives_the_same_bits_from_its_own_format(
    loop_ssp: Path, expected: Rows, tmp_path: Path
) -> None:
    export_wiring(loop_ssp, tmp_path, "osp", SECONDS)
    package = read_ssp(loop_ssp)
    result = libcosim_rows("from_osp_config_file", tmp_path, package)
    assert_same_bits(result, expected, "libcosim, OspSystemStructure.xml")


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
        data = rows_of(stored["rows"], json.loads(str(stored["names"])))
    shown = {name: values for name, values in early.items() if not name.startswith("reference.")}
    assert_same_bits({name: data[name] for name in shown}, shown, "cofmupy")


@pytest.mark.slow
def test_maestro_gives_the_same_bits(loop_ssp: Path, expected: Rows, tmp_path: Path) -> None:
    """All FMUs, with the program that the export writes. Its row k is seen at base step k."""
    program = export_wiring(loop_ssp, tmp_path, "maestro", SECONDS)[-1]
    call = ["interpret", program.name, "-runtime", "maestro-run.json", "-output", "out"]
    result = maestro_rows(call, tmp_path)
    assert_same_bits({name: result[name] for name in expected}, expected, "Maestro")


@pytest.mark.slow
def test_maestro_says_which_component_failed(loop_ssp: Path, tmp_path: Path) -> None:
    """A step size that every FMU refuses. Maestro writes the message and exits with 0."""
    program = export_wiring(loop_ssp, tmp_path, "maestro", SECONDS)[-1]
    program.write_text(program.read_text().replace(f"real h = {BASE!r};", "real h = 0.0001;"))
    done = run_maestro(["interpret", program.name, "-runtime", "maestro-run.json"], tmp_path)
    assert "reference: doStep failed" in done.stdout + done.stderr


@pytest.mark.slow
def test_maestro_gives_the_same_bits_from_a_multi_model(loop_ssp: Path, tmp_path: Path) -> None:
    """Reference, feedback and plant, 2 s; against a run whose feedforward counts nothing.

    Maestro 2.3.0 makes a program of a multi-model itself; to do so it compares all statements
    text by text, which takes half a minute for 3 FMUs and was not through after 16 min for 8.
    It sums its time, hence one step more is asked for.
    """
    package, kept = read_ssp(loop_ssp), {"reference", "feedback", "plant"}
    part = dataclasses.replace(
        package,
        instances=tuple(i for i in package.instances if i.name in kept),
        wires=tuple(w for w in package.wires if {w.source, w.target} <= kept),
    )
    export_wiring(loop_ssp, tmp_path, "maestro", SECONDS)
    (tmp_path / "three.json").write_text(maestro(part, SECONDS + BASE), encoding="utf-8")
    call = ["import", "Sg1", "three.json", "-fsp", ".", "-nop", "-output", "out", "-i"]
    actual = maestro_rows(call, tmp_path)
    alone = own_rows(loop_ssp, parameters={"feedback.ff_gain": 0.0})
    shown = {name: alone[name] for name in alone if name in actual}
    assert len(shown) >= 19, "hardly anything was compared"
    assert_same_bits({name: actual[name] for name in shown}, shown, "Maestro, multi-model")


def run_maestro(words: Sequence[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run Maestro in a folder; it exits with 0 whatever happens."""
    call = ["java", "-jar", tool("FLEXHEX_MAESTRO", f"~/.m2/repository/{MAESTRO_JAR}", MAESTRO)]
    return subprocess.run([*call, *words], cwd=folder, capture_output=True, text=True, check=False)


def maestro_rows(words: Sequence[str], folder: Path) -> Rows:
    """Rows at base steps 1, 2, ... of `out/outputs.csv`; its names may carry the FMU's key."""
    done = run_maestro(words, folder)
    result = folder / "out" / "outputs.csv"
    assert result.exists(), (done.stdout + done.stderr)[-2000:]
    with result.open(newline="") as file:
        (_, *names), _, *rows = csv.reader(file)
    values = [[float(x) for x in row[1:]] for row in rows[:N_STEPS]]
    return rows_of(values, [name.rpartition("}.")[2] for name in names])


@pytest.mark.parametrize("name", sorted(WIRINGS))
def test_wiring_names_every_fmu_and_connection(loop_ssp: Path, tmp_path: Path, name: str) -> None:
    written = export_wiring(loop_ssp, tmp_path, name, SECONDS)
    package, texts = (
        read_ssp(loop_ssp),
        {p.name: p.read_text() for p in written if p.suffix != ".fmu"},
    )
    assert texts.keys() == WIRINGS[name].keys()
    assert {p.name for p in written} - texts.keys() == {Path(s).name for s in package.fmus}
    counted = {
        "cofmupy.json": lambda text: len(json.loads(text)["connections"]),
        "maestro.json": lambda text: sum(map(len, json.loads(text)["connections"].values())),
        "maestro.mabl": lambda text: len(re.findall(r"_u\[\d+\] = c_\w+_y\[\d+\];", text)),
        "OspSystemStructure.xml": lambda text: text.count("<VariableConnection>"),
    }
    for file, text in texts.items():
        if file in counted:
            assert all(Path(s).name in text for s in package.fmus), file
            assert counted[file](text) == len(package.wires), file


def test_tool_without_a_format_is_refused(loop_ssp: Path, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no wiring for 'simulink', there is one for: cofmupy"):
        export_wiring(loop_ssp, tmp_path, "simulink", SECONDS)

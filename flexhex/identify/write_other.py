"""`identify --write FILE` of any base model but the hexapod: the robot's file with what was found,
or all values with their intervals (.csv, .json)."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Container, Sequence
from pathlib import Path

from flexhex.diagnose.options import refuse_unwritable
from flexhex.diagnosis.estimation.friction import PARAMETER
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.kinds import axes_named
from flexhex.fmus.common.errors import UsageError
from flexhex.identify.other import identified_json

ENDING = ".toml"
"""Of what stands beside a robot's file."""
TABLES = (".csv", ".json")


def checked_target(path: Path, base: str) -> None:
    """UsageError or OutputError, before anything is computed, for a file that cannot be written."""
    from flexhex.diagnosis.basemodels.robot_file import is_robot
    from flexhex.diagnosis.basemodels.robot_more import read_more
    from flexhex.diagnosis.machine_files.robot_beside import written_by_us

    file = read_more(base).file
    own = is_robot(base) and file.suffix != ".sdf"
    kinds = (file.suffix, *TABLES) if own else TABLES
    if path.suffix not in kinds:
        robot = f"{kinds[0]} for the robot's file, " if own else ""
        raise UsageError(
            f"--write {path}: write {robot}.csv or .json for all values with their intervals;"
            " --fmu inverse.fmu builds the inverse dynamics"
        )
    if is_robot(base) and path.resolve() == file.resolve():
        raise UsageError(f"--write {path}: is the robot's file itself: name another file")
    if own and path.suffix not in TABLES:
        for beside in (path.with_suffix(ENDING), path.with_suffix(".json")):
            if beside.is_file() and not written_by_us(beside):
                raise UsageError(
                    f"--write {path}: {beside} would be overwritten, too: name another file"
                )
    refuse_unwritable(path, "--write")


def checked_fmu(path: Path) -> None:
    """The same of the file of `--fmu`."""
    if path.suffix != ".fmu" or not re.fullmatch(r"[A-Za-z_]\w*", path.stem, re.ASCII):
        raise UsageError(
            f"--fmu {path}: name a file like inverse.fmu, of letters, digits and underscores"
        )
    refuse_unwritable(path, "--fmu")


def checked_motion(path: Path) -> None:
    """The same of the file of `--next`."""
    if path.suffix != ".csv":
        raise UsageError(f"--next {path}: name a file like next.csv")
    refuse_unwritable(path, "--next")


def write_identified(path: Path, identified: Identified) -> tuple[list[Path], list[str]]:
    """Write what was identified: the files, and what who uses them must know. Beside a robot's file
    stands a TOML with what it has no place for, and all values with their intervals as JSON."""
    if path.suffix == ".csv":
        path.write_text(_csv(identified), encoding="utf-8")
        return [path], []
    if path.suffix == ".json":
        path.write_text(identified_json(identified) + "\n", encoding="utf-8")
        return [path], []
    from flexhex.diagnosis.basemodels.robots import RobotBase
    from flexhex.diagnosis.machine_files.robot_beside import beside_text
    from flexhex.diagnosis.machine_files.robot_write import write_robot

    base = identified.estimated.model.base
    assert isinstance(base, RobotBase)
    values = {one.name: one.estimate.value for one in identified.parameters}
    for extra in identified.estimated.extras.listed:
        # what has friction in its gains stands in its place, in the TOML alone as a whole
        if extra.effect.extends in PARAMETER:
            name = f"{PARAMETER[extra.effect.extends]}[{extra.axis + 1}]"
            values[name] = values[extra.parameter(extra.effect.gains[0].name)]
    beside, whole = path.with_suffix(ENDING), path.with_suffix(".json")
    text, there = beside_text(beside, path, identified)
    left, scaled = write_robot(path, base, base.file, values)
    beside.write_text(text, encoding="utf-8")
    whole.write_text(identified_json(identified) + "\n", encoding="utf-8")
    notes = _without(path, beside, [name for name in left if values[name]], there)
    early = [i for i, form in enumerate(identified.estimated.forms) if form.lead]
    if early:
        notes.append(
            f"friction on {axes_named(early)} turns over before the rate does, as that of"
            f" simulators: {beside} has it turn over with the rate"
        )
    for share in sorted({*scaled.values()}):
        names = ", ".join(name for name, own in scaled.items() if own == share)
        notes.append(
            f"{path}: there {names} {'has' if ', ' not in names else 'have'} {share:.2g} of the"
            " file's mass and inertia: with all of it no body would be left for the link that"
            " carries it"
        )
    return [path, beside, whole], notes


def _without(path: Path, beside: Path, left: Sequence[str], there: Container[str]) -> list[str]:
    """Sentences on values for which a robot's file has no place, and the TOML has, or has none."""
    texts, own = list[str](), [name for name in left if name in there]
    if own:
        texts.append(
            f"{path} has no place for {', '.join(own)}: torques from it alone lack them; {beside}"
            f" has them, too (--base {beside}), and --fmu builds all of it"
        )
    if rest := [name for name in left if name not in there]:
        texts.append(f"{', '.join(rest)}: in neither {path} nor {beside}, in the .json alone")
    return texts


def _csv(identified: Identified) -> str:
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(("name", "unit", "value", "low", "high", "file", "determined"))
    for one in (*identified.parameters, *(c for c in identified.combinations if len(c.terms) > 1)):
        e = one.estimate
        numbers = (repr(float(v)) for v in (e.value, *e.ci95, one.file))
        table.writerow((one.name, e.unit, *numbers, str(one.determined).lower()))
    return text.getvalue()

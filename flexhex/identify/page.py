"""What `flexhex identify` found, as one offline page: prediction of a run, parameters, files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnose.numbers import number
from flexhex.diagnose.page import digest
from flexhex.diagnose.plots import strip_figures
from flexhex.diagnose.titles import effort
from flexhex.diagnosis.estimation.records import Identified
from flexhex.identify.other import Pointers, has_file, identified_parts
from flexhex.identify.simulated import simulation_section
from flexhex.output.page import PageSection, write_page
from flexhex.output.parts import Sentence, Titled
from flexhex.output.tables import texts

Array = NDArray[np.float64]
IN_FILE = Pointers("identified.json has them", "identified.json has them whole")


def write_identified_page(
    path: Path, identified: Identified, command: str, files: Sequence[Path]
) -> Path:
    """The page; files: the runs and held-out runs, listed with their hashes."""
    parts = identified_parts(identified, rest=IN_FILE)
    tables = [
        PageSection(part.title, "", *texts(part.columns, part.rows))
        for part in parts
        if isinstance(part, Titled)
    ]
    said = [(part.text.strip(),) for part in parts if isinstance(part, Sentence)]
    sections = [
        *_strips(identified),
        *_simulated(identified),
        PageSection("Prediction", answer(identified), answer=True),
        *tables,
        *([PageSection("Notes", "", ("",), said, words=True)] if said else []),
        _files(identified, files),
    ]
    return write_page(path, "What the runs say of the model", command, sections)


def answer(identified: Identified) -> str:
    """A sentence on what is left of the torque, with the file's values and with the estimates."""
    errors = identified.errors if identified.held_out is None else identified.held_out
    where = "the runs that were fitted" if identified.held_out is None else "held-out runs"
    called, after = effort(identified.units), _percent(errors.fitted)
    before = f", the values of the file {_percent(errors.file)}" if has_file(identified) else ""
    return f"Of the {called} of {where} the estimates leave {after}{before}."


def _percent(shares: Array) -> str:
    ends = dict.fromkeys(number(100 * float(of(shares)), 2) for of in (np.nanmin, np.nanmax))
    return f"{' to '.join(ends)} %"


def _strips(identified: Identified) -> list[PageSection]:
    if not identified.strips:
        return []
    one, called = identified.strips[0], effort(identified.units)
    kind = "a held-out run" if one.held_out else "one of the runs that were fitted"
    before = "the file's values" if has_file(identified) else "no model"
    text = (
        f"{Path(one.run).name}, {kind}: measured {called}, and that of {before} (before) and of the"
        " estimates (after); below, what each leaves."
    )
    if len(identified.strips) > 1:
        text += " The buttons choose the axis."
    drawn = strip_figures(identified.strips, _worst(identified))
    return [PageSection(f"{called.capitalize()} over time", text, figures=drawn, timed=True)]


def _simulated(identified: Identified) -> list[PageSection]:
    told = identified.simulation
    if told is None:
        return []
    return [simulation_section(told, effort(identified.units), _worst(identified))]


def _worst(identified: Identified) -> int:
    """The axis, from 1, of which most of the torque is left."""
    errors = identified.errors if identified.held_out is None else identified.held_out
    return int(np.argmax(np.nan_to_num(errors.fitted * errors.torque, nan=-1.0))) + 1


def _files(identified: Identified, files: Sequence[Path]) -> PageSection:
    held_out = {*identified.held_out_runs}
    rows = [(str(p), "held out" if str(p) in held_out else "fit", digest(p)) for p in files]
    return PageSection("Files", "", ("file", "used as", "SHA-256"), rows, words=True, folded=True)

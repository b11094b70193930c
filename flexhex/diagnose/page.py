"""A diagnosis as one offline page: verdict, evidence, what to do next."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexhex.diagnose.changes import allowed
from flexhex.diagnose.effects import EFFECTS, effect_rows, undetermined
from flexhex.diagnose.maps import map_figures, spectrum_figures
from flexhex.diagnose.next import Invocation, next_steps, shortened
from flexhex.diagnose.plots import candidate_bars, residual_bars, strip_figures
from flexhex.diagnose.titles import effort, readable
from flexhex.diagnose.view import (
    CHANGED,
    IDENTIFIED,
    LOOPS,
    SIDES,
    axis_names,
    changed_rows,
    judged,
    parameter_rows,
    parameters_title,
    remarks,
    residual_columns,
    residual_rows,
    residual_title,
    shown_lines,
    vague,
)
from flexhex.diagnose.words import residual_name, verdict
from flexhex.diagnosis.result.verdict import Diagnosis
from flexhex.output.page import PageSection, write_page
from flexhex.output.plots import Figure

Array = NDArray[np.float64]


def write_diagnosis(
    diagnosis: Diagnosis, invocation: Invocation, files: Sequence[Path], path: Path
) -> Path:
    """The page; files: the runs and held-out runs, listed with their hashes."""
    parts = [
        *_strips(diagnosis),
        PageSection(f"Verdict: {diagnosis.verdict}", _verdict(diagnosis), answer=True),
        *_effects(diagnosis),
        *_residual(diagnosis),
        *_tracking(diagnosis.shown),
        *_next(diagnosis, invocation),
        *_maps(diagnosis),
        *_remarks(diagnosis),
        *_candidates(diagnosis),
        _files(diagnosis, files),
    ]
    command = shortened(invocation.words)
    return write_page(path, "What the model lacks", command, parts)


def _verdict(diagnosis: Diagnosis) -> str:
    planned = [
        f"An experiment that distinguishes them: {e.experiment}."
        for e in diagnosis.effects
        if e.experiment
    ]
    return " ".join([verdict(diagnosis), *planned])


def _strips(diagnosis: Diagnosis) -> list[PageSection]:
    """Torque and residual over time of one run, one axis at a time."""
    if not diagnosis.strips:
        return []
    one = diagnosis.strips[0]
    kind = "a held-out run" if one.held_out else "one of the runs"
    called = effort([strip.unit for strip in diagnosis.strips])
    text = (
        f"{Path(one.run).name}, {kind}: measured {called}, and that of the model before and"
        " after what was found is added; below, what each leaves."
    )
    if len(diagnosis.strips) > 1:
        text += " The buttons choose the axis."
    if diagnosis.residual.resting.any():
        text += " No model is drawn while an axis rests, as dry friction carries any load then."
    drawn = strip_figures(diagnosis.strips, matters(diagnosis))
    return [PageSection(f"{called.capitalize()} over time", text, figures=drawn, timed=True)]


def matters(diagnosis: Diagnosis) -> int:
    """The axis (from 1) to look at first: that of the first effect, else where most repeats."""
    axes = [axis for effect in diagnosis.effects for axis in effect.axes]
    repeatable = np.nan_to_num(diagnosis.residual.repeatable, nan=-1.0)
    return axes[0] if axes else int(np.argmax(repeatable)) + 1


def _effects(diagnosis: Diagnosis) -> list[PageSection]:
    parts = []
    if diagnosis.effects:
        whole = residual_name(diagnosis.residual)
        text = f"± and ranges are 95 % intervals. Explains: of {whole} on its axes."
        text = ". ".join([text.rstrip("."), *undetermined(diagnosis)]) + "."
        rows = effect_rows(diagnosis)
        parts.append(PageSection("Effects that the model lacks", text, EFFECTS, rows, words=True))
    if diagnosis.changed:
        text = "Parameters of the model that deviate from the machine file."
        parts.append(PageSection("Changed parameters", text, CHANGED, changed_rows(diagnosis)))
    if diagnosis.parameters:
        text, rows = " ".join(vague(diagnosis)), parameter_rows(diagnosis)
        parts.append(PageSection(parameters_title(diagnosis), text, IDENTIFIED, rows, words=True))
    return parts


def _residual(diagnosis: Diagnosis) -> list[PageSection]:
    residual = diagnosis.residual
    if not np.isfinite(residual.before).any():
        return []
    values = judged(diagnosis)
    sides = values["before"], values["after"], values["non_repeatable"]
    drawn = residual_bars(
        "Residual", residual.unit, *sides, [f"axis {name}" for name in axis_names(residual)]
    )
    text = (
        "The non-repeatable residual differs between passes of one trajectory; no model reduces it."
    )
    return [
        PageSection(
            residual_title(residual),
            " ".join([text, *allowed(diagnosis)]),
            residual_columns(residual),
            residual_rows(diagnosis),
            {"residual": drawn},
        )
    ]


def _tracking(shown: Mapping[str, Any]) -> list[PageSection]:
    figures: dict[str, Figure] = {}
    for k, (run, residuals) in enumerate(shown.get("simulation_residual", {}).items()):
        before, after = (np.asarray(residuals[side], dtype=np.float64) for side in SIDES)
        name = f"Simulation of {Path(run).name}"
        figures[f"replay{k}"] = residual_bars(name, "N m", before, after)
    if loops := shown.get("closed_loop", {}):
        before, after = (np.array([sides[s]["e"] for sides in loops.values()]) for s in SIDES)
        names = [f"on the {LOOPS.get(kind, kind)}" for kind in loops]
        figures["loop"] = residual_bars("Tracking error", "µrad", before, after, names=names)
    lines = shown_lines(shown)
    text = " ".join(f"{line}." for line in lines)
    return [PageSection("Rebuilt and run", text, figures=figures, small=True)] if lines else []


def _next(diagnosis: Diagnosis, invocation: Invocation) -> list[PageSection]:
    steps = next_steps(diagnosis, invocation)
    return [PageSection("What to do next", "", ("", "command"), steps, words=True)] if steps else []


def _candidates(diagnosis: Diagnosis) -> list[PageSection]:
    if not diagnosis.candidates:
        return []
    numbers = sorted({c.round for c in diagnosis.candidates})
    drawn = {
        f"round{k}": candidate_bars(k, [c for c in diagnosis.candidates if c.round == k])
        for k in numbers
    }
    text = (
        "What each hypothesis adds to the log density of trajectories that it was not fitted to, in"
        " nats: 3 nats are odds of 20. Base model, gains and shapes are those of the other"
        " trajectories. Indistinguishable ones predict as well as the one that was accepted. Of two"
        " forms of one effect the fuller one is accepted only where it predicts better."
    )
    title = f"Candidates of the {len(numbers)} rounds" if len(numbers) > 1 else "Candidates"
    return [PageSection(title, text, figures=drawn, small=True, folded=True)]


def _maps(diagnosis: Diagnosis) -> list[PageSection]:
    first = matters(diagnosis)
    parts = []
    if means := map_figures(diagnosis.maps, first):
        text = "Mean of the repeatable residual; the band is two standard errors wide to each side."
        parts.append(PageSection("Where the residual is", text, figures=means, small=True))
    if spectra := spectrum_figures(diagnosis.maps, first):
        parts.append(PageSection("Spectrum of the residual", figures=spectra))
    return parts


def _remarks(diagnosis: Diagnosis) -> list[PageSection]:
    parts = []
    if notes := remarks(diagnosis):
        parts.append(PageSection("Notes", "", ("",), [(note,) for note in notes], words=True))
    rows = [(readable(text),) for text in diagnosis.findings]
    text = "" if rows else "The logs gave no reason for a remark."
    return [*parts, PageSection("Findings in the logs", text, ("",), rows, words=True)]


def _files(diagnosis: Diagnosis, files: Sequence[Path]) -> PageSection:
    held_out = set(diagnosis.held_out)
    rows = [(str(p), "held out" if str(p) in held_out else "fit", digest(p)) for p in files]
    return PageSection("Files", "", ("file", "used as", "SHA-256"), rows, words=True, folded=True)


def digest(path: Path) -> str:
    """First half of a file's SHA-256, read in blocks; a dash where there is no file."""
    if not path.is_file():
        return "–"
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:32]

"""Command `check`: FMUs, system descriptions and machine files against their rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer


def check_command(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE", help="FMUs, system descriptions, machine files")
    ],
    results: Annotated[
        bool, typer.Option("--results", help="run FMUs against the results that they carry")
    ] = False,
) -> None:
    """Check FMUs (FMI rules, binary), .ssp (wiring, units, sample times) and machine files.

    Exit code 0: no complaints, maybe warnings of what is allowed but unusual. 1: complaints.
    """
    from flexhex.check.files import check_file, warnings_of

    if results:
        compare_with_carried_results(files)
        return
    findings = {path: check_file(path) for path in files}
    warnings = {path: [] if errors else warnings_of(path) for path, errors in findings.items()}
    print_findings(findings, warnings)
    if any(findings.values()):
        raise typer.Exit(1)


def compare_with_carried_results(files: list[Path]) -> None:
    """Print the worst deviation of every output of FMUs; exit code 1 beyond tolerance."""
    from flexhex.check.results import check_results, print_deviations

    compared = {path: check_results(path) for path in files}
    print_deviations(compared)
    if not all(d.good for deviations in compared.values() for d in deviations):
        raise typer.Exit(1)


def print_findings(
    findings: Mapping[Path, Sequence[str]], warnings: Mapping[Path, Sequence[str]]
) -> None:
    """One line for each file that is well, after its warnings; the complaints of the others."""
    for path, complaints in findings.items():
        for text in (*complaints, *warnings[path]):
            print(text)
        if not complaints:
            print(f"{path}: ok")

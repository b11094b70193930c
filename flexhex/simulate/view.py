"""What a simulation shows in the terminal: time spent in each FMU, faults."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from flexhex.simulation.faults import Fault, faults
from flexhex.ssp.results import Result


def speed_table(result: Result, title: str) -> Table:
    table = Table(title=title, box=SIMPLE_HEAD)
    table.add_column("FMU")
    for name in ("steps", "µs a step", "ms per simulated s"):
        table.add_column(name, justify="right")
    for name, spent in result.times.items():
        mean = spent.seconds / max(spent.steps, 1) * 1e6
        share = spent.seconds / result.duration * 1e3
        table.add_row(name, str(spent.steps), f"{mean:.2f}", f"{share:.2f}")
    return table


def print_speed(result: Result) -> None:
    """Time spent in each FMU, and the faults that were reported."""
    out = Console()
    out.print(speed_table(result, "Time in each FMU"))
    print_faults(out, faults("the run", result))


def print_faults(out: Console, listed: Sequence[Fault]) -> None:
    """One line for each component that reported a fault: which, how often, since when."""
    for fault in listed:
        out.print(f"[red]fault[/] in {fault}; see fmus/*/README.md", highlight=False)

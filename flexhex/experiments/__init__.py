"""Experiments beyond Table I, each one module and one part of the report.

An experiment is a module with `run(builder, fit, progress, command, quick)`, `COLUMNS`,
`rows(result)` and `figures(result)`, and a fragment `<name>.html.j2` that shows them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import resources
from typing import Any

from flexhex.experiments import (
    estimates,
    estimates_view,
    hysteresis,
    missing,
    payload,
    repeatability,
)
from flexhex.fmus.common.errors import UsageError
from flexhex.output.plots import Figure
from flexhex.output.tables import Column, html


@dataclass(frozen=True)
class Experiment:
    """One experiment. run(builder, fit, progress, command, quick) -> its result, which `figures`
    (by the id of their place) and `rows`, shown in `columns`, turn into plots and a table.
    with_truth: of a machine that differs from its model alone. data: its part of `--json`."""

    name: str
    title: str
    run: Callable[..., Any]
    figures: Callable[[Any], dict[str, Figure]]
    rows: Callable[[Any], list[dict[str, Any]]]
    columns: tuple[Column, ...]
    with_truth: bool = False
    data: Callable[[Any], Any] | None = None


EXPERIMENTS: dict[str, Experiment] = {
    experiment.name: experiment
    for experiment in (
        Experiment(
            "repeatability",
            "Repeatability",
            repeatability.run,
            repeatability.figures,
            repeatability.rows,
            repeatability.COLUMNS,
        ),
        Experiment(
            "hysteresis",
            "Cogging and hysteresis",
            hysteresis.run,
            hysteresis.figures,
            hysteresis.rows,
            hysteresis.COLUMNS,
        ),
        Experiment(
            "payload",
            "Changing end-effector mass",
            payload.run,
            payload.figures,
            payload.rows,
            payload.COLUMNS,
        ),
        Experiment(
            "parameters",
            "Parameters",
            estimates.run,
            estimates_view.figures,
            estimates_view.rows,
            estimates_view.COLUMNS,
        ),
        Experiment(
            "missing",
            "What the model lacks",
            missing.run,
            missing.figures,
            missing.rows,
            missing.COLUMNS,
            with_truth=True,
            data=missing.data,
        ),
    )
}
"""All experiments by the name that `flexhex run --only NAME` takes, in the report's order."""


def experiment(name: str) -> Experiment:
    """The experiment of that name; UsageError names those that there are."""
    if name not in EXPERIMENTS:
        raise UsageError(f"no experiment {name!r}: there are {', '.join(EXPERIMENTS)}")
    return EXPERIMENTS[name]


def render(name: str, result: Any) -> Any:
    """The fragment of one experiment as safe HTML (markupsafe.Markup).

    Its plots stand in empty <div>s with the ids of `figures`; the report draws them.
    """
    import jinja2
    from markupsafe import Markup

    chosen = experiment(name)
    source = resources.files(__name__) / f"{name}.html.j2"
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    template = environment.from_string(source.read_text(encoding="utf-8"))
    rows = chosen.rows(result)
    fragment = template.render(
        title=chosen.title,
        result=result,
        rows=rows,
        table=html(chosen.columns, rows),
        places=list(chosen.figures(result)),
    )
    return Markup(fragment)

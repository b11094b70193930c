"""Results of the diagnosis that are the same whatever its criteria are, kept between answers about
the same logs in one process."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

Function = Callable[..., Any]


@contextmanager
def remembered() -> Iterator[None]:
    """The base model's fit, and the scores of an axis beside what was accepted before, are computed
    once."""
    workflow: Any = importlib.import_module("flexhex.diagnosis.workflow")
    mechanism: Any = importlib.import_module("flexhex.diagnosis.mechanism")
    search: Any = importlib.import_module("flexhex.diagnosis.selection.search")
    before = workflow.run_set_of, workflow.fitted, mechanism.beside, search.effect_scores
    workflow.run_set_of = kept(workflow.run_set_of, lambda *given: ())
    workflow.fitted = kept(workflow.fitted, lambda *given: ())
    mechanism.beside = kept(mechanism.beside, lambda fit: (id(fit.bench.model), *_key_of_fit(fit)))
    search.effect_scores = kept(search.effect_scores, key_of_scores)
    try:
        yield
    finally:
        workflow.run_set_of, workflow.fitted, mechanism.beside, search.effect_scores = before


def kept(function: Function, key: Callable[..., Hashable]) -> Function:
    """A function whose results are kept by a key of its arguments; these are kept too, so that
    none of them can have another one's `id`."""
    known: dict[Hashable, tuple[Any, Any]] = {}

    def lookup(*given: Any) -> Any:
        name = key(*given)
        if name not in known:
            known[name] = given, function(*given)
        return known[name][1]

    return lookup


def _key_of_fit(fit: Any) -> tuple[Hashable, ...]:
    """What a joint fit is of: effects with their shapes, parameters that were freed."""
    parts = [(part.id, part.axis, tuple(sorted(part.shape.items()))) for part in fit.parts]
    return (*parts, *sorted(fit.freed.items()))


def key_of_scores(
    moments: Any, hypotheses: Any, known: Sequence[Any], criteria: Any, axes: Sequence[Any]
) -> Hashable:
    accepted = []
    for score in known:
        h = score.hypothesis
        shape = tuple(sorted(h.shapes[score.shape].items())) if hasattr(h, "shapes") else h.places
        accepted.append((h.id, h.axis, shape))
    model = id(hypotheses.bench.model)
    decide = criteria.shortlist, criteria.loose, criteria.most
    # feedback's answer to noise is a term that no effect has; errors of a form depend on criteria
    priors = [term.prior * moments.tight.get(term, 1.0) for term in moments.terms]
    terms = tuple(
        (*term.white, prior.tobytes()) for term, prior in zip(moments.terms, priors, strict=True)
    )
    return model, tuple(accepted), terms, decide, tuple(axes)

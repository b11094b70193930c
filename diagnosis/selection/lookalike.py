"""Effects that wide shapes of another one look like: these are chosen beside them.

Friction that turns over within a wide rate looks like one that turns over at once, and viscous
friction. Chosen where that is not in the model yet, the rate would stand for it.
"""

from __future__ import annotations

from collections.abc import Collection

from flexhex.diagnosis.selection.evidence import free
from flexhex.diagnosis.selection.hypotheses import Hypotheses
from flexhex.diagnosis.selection.hypothesis import EffectHypothesis
from flexhex.diagnosis.selection.moments import Moments, Term


def beside_lookalike(
    moments: Moments, hypotheses: Hypotheses, effect: EffectHypothesis, there: Collection[str]
) -> Moments:
    """A model with the effect that wide shapes of another one look like on its axis; the model
    itself where the axis cannot lack that, or has it (`there`: ids of what was accepted on it). The
    last one is kept: effects of an axis want the same."""
    item = hypotheses.bench.effects.get(effect.id)
    key = item.effect.imitates if item else "", effect.axis
    if key[0] in there or key[0] not in hypotheses.bench.names(effect.axis):
        return moments
    if key not in hypotheses.imitated:
        hypotheses.imitated[key] = _term(moments, hypotheses, hypotheses.effect(*key))
    if hypotheses.longer is None or hypotheses.longer[:2] != (moments, key):
        hypotheses.longer = moments, key, moments.extended(hypotheses.imitated[key])
    return hypotheses.longer[2]


def _term(moments: Moments, hypotheses: Hypotheses, effect: EffectHypothesis) -> Term:
    columns = hypotheses.columns(effect, effect.shapes[0])
    return Term(columns.raw, columns.white, free(moments, effect, effect.beside(moments))[0])

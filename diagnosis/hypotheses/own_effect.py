"""Effects that users wrote, beside the library's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flexhex.fmus.common.effects import Effect, library
from flexhex.fmus.common.effects.own import OwnEffect, own_effect
from flexhex.fmus.common.errors import UsageError


def own_effects(texts: Sequence[str]) -> dict[str, OwnEffect]:
    """Effects of `--effect` by id: `FILE.py:NAME` or the name that a package offers, each.

    Raises UsageError for what is not there, MachineError for what is no effect.
    """
    effects: dict[str, OwnEffect] = {}
    for text in texts:
        effect = own_effect(text, "--effect")
        if effect.id in effects:
            raise UsageError(f"--effect {text}: there are two effects {effect.id}: rename one")
        effects[effect.id] = effect
    return effects


def with_own(own: Mapping[str, OwnEffect], more: Sequence[OwnEffect]) -> dict[str, OwnEffect]:
    """These and others, by id. UsageError for two of one name that are not one."""
    effects = dict(own)
    for effect in more:
        there = effects.setdefault(effect.id, effect)
        if there.origin != effect.origin:
            raise UsageError(f"{effect.origin}: {there.origin} is called so, too: rename one")
    return effects


def sought(own: Mapping[str, OwnEffect]) -> dict[str, Effect]:
    """The library for the mechanism, with what can stand behind the drives' reports; and the user's
    own effects."""
    return {id: effect.behind or effect for id, effect in library().items()} | dict(own)

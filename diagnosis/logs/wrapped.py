"""Angles that a drive reports within one turn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from flexhex.diagnosis.kinds import Kinds
from flexhex.diagnosis.logs.log import Channel, Finding
from flexhex.diagnosis.logs.values import JUMP, jumps

TURN = 2 * np.pi
Sound = Callable[[str, str, Channel], tuple[Channel, list[Finding]]]
"""From file, name and channel to the same without what is wrong with it."""


def of_angles(kinds: Kinds) -> tuple[Sound, ...]:
    """What is done to angles, one after the other."""
    return partial(unwrapped, kinds), jumps


def unwrapped(
    kinds: Kinds, where: str, name: str, channel: Channel
) -> tuple[Channel, list[Finding]]:
    """Angles (samples, n) [rad] of axes that turn go on beyond a turn: they jump by a whole one, as
    no axis moves, and beside that no farther than it goes elsewhere."""
    values, findings = channel.values, list[Finding]()
    both = channel.valid[1:] & channel.valid[:-1]
    for axis, kind in enumerate(kinds[: channel.width]):
        moved = np.diff(channel.values[:, axis])
        turns = np.round(moved / TURN) * both
        turned, rest = turns != 0, np.abs(moved - TURN * turns) * both
        usual = float(rest[~turned].max(initial=0.0))
        if np.abs(turns).max(initial=0) != 1 or rest[turned].max() > usual or JUMP * usual > TURN:
            continue
        if kind.turns:
            values = values.copy()
            values[1:, axis] -= TURN * np.cumsum(turns)
            count = int(np.count_nonzero(turns))
            text = f"{name}[{axis + 1}] jumps by a whole turn {count} times: made continuous"
            findings.append(Finding("wrapped", where, text, True))
    return replace(channel, values=values), findings

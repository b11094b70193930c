"""Which values of straight-line code are computed side by side, two in one instruction.

A mechanism with equal arms computes the same expressions arm by arm, and nothing in the list of
operations says so any more. It is found again here, in two sweeps. In the first, values are alike
when the same operations lead to them, whatever the constants and the elements of the inputs; in
the second, when the same operation computes them equally far from the inputs. Either way neither
of two needs the other, and all pairs together can be put in order.

The largest values are paired first, each with the one from which most pairs follow down to the
inputs. Every value is still computed by its own operations in their own order, so pairing changes
no bit.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import ChainMap, defaultdict
from collections.abc import Hashable, Mapping, Sequence

import casadi as ca

from flexhex.fmugen.graph import COMMUTATIVE, Graph, Node

VECTOR = {
    ca.OP_ADD: "ADD", ca.OP_SUB: "SUB", ca.OP_MUL: "MUL", ca.OP_DIV: "DIV",
    ca.OP_NEG: "NEG", ca.OP_SQ: "SQUARE", ca.OP_TWICE: "TWICE",
}  # fmt: skip
"""Operations on pairs, and their names in pair.h."""
NEAR, WITHIN = 8, 64
"""Candidates that are tried for a value: the nearest in the code that are not paired yet, of so
many alike before and after it. More cost build time and give the same code."""
Pair = tuple[int, int]


class Lanes:
    """pair: node -> the one beside it, both ways; only operations of VECTOR and inputs."""

    def __init__(self, graph: Graph) -> None:
        self.nodes: Sequence[Node] = graph.nodes
        self.pair: dict[int, int] = {}
        size = _sizes(graph.nodes)
        operations = [k for k, node in enumerate(graph.nodes) if node.op in VECTOR]
        operations.sort(key=lambda k: -size[k])
        for alike in (_shapes(graph.nodes), _levels(graph.nodes)):
            self._alike = alike
            groups: dict[int, list[int]] = defaultdict(list)
            for k in sorted(operations):
                if k not in self.pair:
                    groups[alike[k]].append(k)
            for k in operations:
                if k not in self.pair:
                    self.pair |= self._best(k, groups[alike[k]])

    def aligned(self, a: int, b: int) -> list[Pair]:
        """Operands of a, in their order, each with the one of b that is beside it."""
        return self._matched(a, b, self.pair)

    def _best(self, a: int, group: Sequence[int]) -> dict[int, int]:
        """Pairs that follow from pairing a with the best of its group; none if none gains."""
        at = bisect_left(group, a)
        window = group[max(0, at - WITHIN) : at + WITHIN + 1]
        free = [b for b in window if b != a and b not in self.pair]
        best, pairing = 0, dict[int, int]()
        for b in sorted(free, key=lambda b: abs(a - b))[:NEAR]:
            trial, gain = self._follow(a, b)
            if gain > best:
                best, pairing = gain, trial
        return pairing

    def _follow(self, a: int, b: int) -> tuple[dict[int, int], int]:
        """Pairs from (a, b) down to the inputs, and the instructions that they save.

        Two values that are not paired with each other must be put side by side: one instruction.
        """
        trial: dict[int, int] = {}
        known, mixed = ChainMap(trial, self.pair), set[Pair]()
        gain, waiting = 0, [(a, b)]
        while waiting:
            x, y = waiting.pop()
            fit = self._fit(x, y, known)
            if fit == 0:
                mixed.add((x, y))
            elif fit == 1:
                trial[x], trial[y] = y, x
                if self.nodes[x].op in VECTOR:
                    gain += 1
                    waiting += reversed(self._matched(x, y, known))
        return trial, gain - len(mixed)

    def _matched(self, a: int, b: int, known: Mapping[int, int]) -> list[Pair]:
        """Operands side by side; those of a sum or product the better way round."""
        mine, theirs = self.nodes[a].operands, self.nodes[b].operands
        straight = list(zip(mine, theirs, strict=True))
        if self.nodes[a].op not in COMMUTATIVE:
            return straight
        crossed = list(zip(mine, theirs[::-1], strict=True))
        fits = [sum(self._fit(x, y, known) for x, y in way) for way in (straight, crossed)]
        return crossed if fits[1] > fits[0] else straight

    def _fit(self, x: int, y: int, known: Mapping[int, int]) -> int:
        """3: paired already; 2: one value for both, or two constants; 1: can be paired; 0: not."""
        if known.get(x) == y:
            return 3
        op = self.nodes[x].op
        if x == y or op == self.nodes[y].op == ca.OP_CONST:
            return 2
        can = self._alike[x] == self._alike[y] and (op in VECTOR or op == ca.OP_INPUT)
        return int(can and x not in known and y not in known)


def _sizes(nodes: Sequence[Node]) -> list[int]:
    """How many operations lead to each node, what is used twice counted twice."""
    size: list[int] = []
    for node in nodes:
        size.append(1 + sum(size[k] for k in node.operands))
    return size


def _shapes(nodes: Sequence[Node]) -> list[int]:
    """A number for each node, the same where the same operations lead to it."""
    shape: list[int] = []
    numbers: dict[Hashable, int] = {}
    for node in nodes:
        operands = [shape[k] for k in node.operands]
        if node.op in COMMUTATIVE:
            operands.sort()
        key = (node.op, *operands, *_argument(node))
        shape.append(numbers.setdefault(key, len(numbers)))
    return shape


def _levels(nodes: Sequence[Node]) -> list[int]:
    """A number for each node, the same where an operation stands equally far from the inputs."""
    depth: list[int] = []
    numbers: dict[Hashable, int] = {}
    level = []
    for node in nodes:
        depth.append(1 + max((depth[k] for k in node.operands), default=-1))
        level.append(numbers.setdefault((node.op, depth[-1], *_argument(node)), len(numbers)))
    return level


def _argument(node: Node) -> tuple[int, ...]:
    """Which argument an input belongs to."""
    return node.args[:1] if node.op == ca.OP_INPUT else ()

"""Which values of straight-line code are computed side by side, two in one instruction.

A mechanism with equal arms computes the same expressions arm by arm, and nothing in the list of
operations says so any more. It is found again here: two nodes have the same shape when the same
operations lead to them, whatever the constants and the elements of the inputs. Nodes of one shape
lie equally deep, so neither needs the other, and pairs of them can be put in order.

The largest values are paired first, each with that of its shape from which most pairs follow
down to the inputs. Every value is still computed by its own operations in their own order, so
pairing changes no bit.
"""

from __future__ import annotations

from collections import ChainMap, defaultdict
from collections.abc import Mapping

import casadi as ca

from flexhex.fmugen.graph import COMMUTATIVE, Graph

VECTOR = {
    ca.OP_ADD: "ADD", ca.OP_SUB: "SUB", ca.OP_MUL: "MUL", ca.OP_DIV: "DIV",
    ca.OP_NEG: "NEG", ca.OP_SQ: "SQUARE", ca.OP_TWICE: "TWICE",
}  # fmt: skip
"""Operations on pairs, and their names in pair.h."""
_MIXED = 2
"""What an operand costs, in instructions, whose two values are not paired with each other: it is
put together, and they are taken out of other pairs."""
Pair = tuple[int, int]


class Lanes:
    """pair: node -> the one beside it, both ways; only operations of VECTOR and inputs."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.shape, self._sorted, self._size = _shapes(graph)
        self.pair: dict[int, int] = {}
        alike: dict[int, list[int]] = defaultdict(list)
        operations = [k for k, node in enumerate(graph.nodes) if node.op in VECTOR]
        for k in operations:
            alike[self.shape[k]].append(k)
        for k in sorted(operations, key=lambda k: -self._size[k]):
            if k not in self.pair:
                self.pair |= self._best(k, alike[self.shape[k]])

    def aligned(self, a: int, b: int) -> list[Pair]:
        """Operands of a paired with those of b, which has a's shape; in the order of a's."""
        mine, theirs = self.graph.nodes[a].operands, self._sorted[b]
        if mine != self._sorted[a]:
            theirs = theirs[::-1]
        return self._matched(mine, theirs, self.graph.nodes[a].op, self.pair)

    def _best(self, a: int, candidates: list[int]) -> dict[int, int]:
        """Pairs that follow from pairing a with the best of the candidates; none if none gains."""
        best: tuple[int, int] = (0, 0)
        found: dict[int, int] = {}
        for b in candidates:
            if b == a or b in self.pair:
                continue
            trial, gain = self._follow(a, b)
            if gain > 0 and (gain, -abs(a - b)) > best:
                best, found = (gain, -abs(a - b)), trial
        return found

    def _follow(self, a: int, b: int) -> tuple[dict[int, int], int]:
        """Pairs from (a, b) down to the inputs, and the instructions that they save."""
        nodes, trial = self.graph.nodes, dict[int, int]()
        known, mixed = ChainMap(trial, self.pair), set[Pair]()
        gain, waiting = 0, [(a, b)]
        while waiting:
            x, y = waiting.pop()
            op = nodes[x].op
            beside = known.get(x), known.get(y)
            if x == y or op == ca.OP_CONST or beside == (y, x):
                continue
            if beside != (None, None) or not (op in VECTOR or op == ca.OP_INPUT):
                mixed.add((x, y))
                continue
            trial[x], trial[y] = y, x
            gain += op in VECTOR
            waiting += reversed(self._matched(self._sorted[x], self._sorted[y], op, known))
        return trial, gain - _MIXED * len(mixed)

    def _matched(
        self, mine: tuple[int, ...], theirs: tuple[int, ...], op: int, known: Mapping[int, int]
    ) -> list[Pair]:
        """Operands side by side; of a product or sum of equal shapes, the better way round."""
        straight = list(zip(mine, theirs, strict=True))
        if op not in COMMUTATIVE or self.shape[mine[0]] != self.shape[mine[1]]:
            return straight
        crossed = list(zip(mine, theirs[::-1], strict=True))

        def fit(pairs: list[Pair]) -> int:
            return sum(self._fit(x, y, known) for x, y in pairs)

        return crossed if fit(crossed) > fit(straight) else straight

    def _fit(self, x: int, y: int, known: Mapping[int, int]) -> int:
        if known.get(x) == y:
            return 3
        if x == y or self.graph.nodes[x].op == ca.OP_CONST:
            return 2
        return 1 if x not in known and y not in known else 0


def _shapes(graph: Graph) -> tuple[list[int], list[tuple[int, ...]], list[int]]:
    """Number of each node's shape, its operands sorted by theirs, operations that lead to it."""
    shape: list[int] = []
    ordered: list[tuple[int, ...]] = []
    size: list[int] = []
    numbers: dict[tuple[int, ...], int] = {}
    for node in graph.nodes:
        operands = node.operands
        if node.op in COMMUTATIVE:
            operands = tuple(sorted(operands, key=lambda k: shape[k]))
        of_input = node.args[:1] if node.op == ca.OP_INPUT else ()
        key = (node.op, *of_input, *(shape[k] for k in operands))
        shape.append(numbers.setdefault(key, len(numbers)))
        ordered.append(operands)
        size.append(1 + sum(size[k] for k in operands))
    return shape, ordered, size

"""A graph as C: one statement for each value or pair of values, from the inputs to the outputs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from flexhex.fmugen.graph import CALLS, INFIX, PATTERNS, Graph
from flexhex.fmugen.lanes import VECTOR, Lanes, Pair

Value = int | Pair
"""A node, or two of them side by side."""


@dataclass(frozen=True)
class Body:
    """Statements of a function; operations on pairs and on single values in them."""

    lines: list[str]
    pairs: int
    singles: int


def body(graph: Graph, ins: Sequence[str], outs: Sequence[str]) -> Body:
    """What computes the outputs; ins, outs: names of the arrays of inputs and results.

    In pairs where that takes fewer statements than one value at a time.
    """
    lanes = Lanes(graph)
    bodies = [_Writer(graph, ins, outs, lanes, pair).body() for pair in (lanes.pair, {})]
    return min(bodies, key=lambda one: len(one.lines))


class _Writer:
    """Statements in the order in which the outputs ask for them: what was computed last is
    used soon, so that it is still in a register."""

    def __init__(
        self,
        graph: Graph,
        ins: Sequence[str],
        outs: Sequence[str],
        lanes: Lanes,
        pair: Mapping[int, int],
    ) -> None:
        self.nodes, self.outputs = graph.nodes, graph.outputs
        self.ins, self.outs, self.lanes, self.pair = ins, outs, lanes, pair
        self.lines: list[str] = []
        self.names: dict[Value, str] = {}
        self.needs: dict[Value, list[Value]] = {}
        self.counts = {"pair": 0, "double": 0}

    def body(self) -> Body:
        for result, element, node in self.outputs:
            self._compute(node)
            self.lines.append(f"{self.outs[result]}[{element}] = {self.names[node]};")
        return Body(self.lines, self.counts["pair"], self.counts["double"])

    def _compute(self, value: Value) -> None:
        waiting = [value]
        while waiting:
            top = waiting[-1]
            if top not in self.needs:
                self.needs[top] = list(self._operands(top))
            missing = [v for v in self.needs[top] if v not in self.names]
            if missing:
                waiting += reversed(missing)
                continue
            waiting.pop()
            if top not in self.names:
                self.names[top] = self._named(top)

    def _operands(self, value: Value) -> Sequence[Value]:
        if isinstance(value, int):
            return [self._whole(value)] if self._in_pair(value) else self.nodes[value].operands
        a, b = value
        if not self._in_pair(a) or self.pair[a] != b:
            return [a, b]
        return self.lanes.aligned(a, b) if a < b else [(b, a)]

    def _in_pair(self, node: int) -> bool:
        return node in self.pair and self.nodes[node].op in VECTOR

    def _whole(self, node: int) -> Pair:
        return min(node, self.pair[node]), max(node, self.pair[node])

    def _named(self, value: Value) -> str:
        """The expression of what needs no statement, or the name of a new one."""
        if isinstance(value, tuple):
            return self._pair(*value)
        node = self.nodes[value]
        if node.op == ca.OP_CONST:
            return literal(node.value)
        if node.op == ca.OP_INPUT:
            return f"{self.ins[node.args[0]]}[{node.args[1]}]"
        if self._in_pair(value):
            whole = self._whole(value)
            return f"{'FIRST' if value == whole[0] else 'SECOND'}({self.names[whole]})"
        self.counts["double"] += 1
        return self._statement("double", written(node.op, [self.names[k] for k in node.args]))

    def _pair(self, a: int, b: int) -> str:
        operands = [self.names[v] for v in self.needs[a, b]]
        if not self._in_pair(a) or self.pair[a] != b:
            return self._statement("pair", f"{{{operands[0]}, {operands[1]}}}")
        if a > b:
            return self._statement("pair", f"{{SECOND({operands[0]}), FIRST({operands[0]})}}")
        self.counts["pair"] += 1
        return self._statement("pair", f"{VECTOR[self.nodes[a].op]}({', '.join(operands)})")

    def _statement(self, kind: str, text: str) -> str:
        name = f"v{len(self.lines)}"
        self.lines.append(f"const {kind} {name} = {text};")
        return name


def written(op: int, operands: Sequence[str]) -> str:
    """C of an operation on single values."""
    if op in INFIX:
        return f"{operands[0]} {INFIX[op]} {operands[1]}"
    if op in CALLS:
        return f"{CALLS[op]}({', '.join(operands)})"
    return PATTERNS[op].format(*operands)


def literal(value: float) -> str:
    """A number as C reads it back exactly, in brackets where a sign stands before it."""
    if math.isnan(value):
        return "NAN"
    text = "INFINITY" if math.isinf(value) else repr(abs(value))
    return f"(-{text})" if math.copysign(1.0, value) < 0 else text

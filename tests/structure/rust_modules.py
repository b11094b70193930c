"""Module graph of a Rust crate, read from its source text, and the circles in it.

A module depends on another when it names an item that the other defines, by `use` or by a path.
Names are followed through re-exports to the module that defines them; a re-export itself
(`pub use`) is no dependency unless the module also uses the name. `mod x;` is none either. Code
and modules under `#[cfg(test)]` are ignored. Dependencies made by methods alone (an `impl` of a
type of the parent module in a child module) are not visible in paths.

A circle is reported between siblings (each with all that lies below it) and the code of their
parent module itself, so a circle between folders counts even where no two files form one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

LONGEST = 250
Name = tuple[str, ...]  # ("cycle", "inputs"); () is the root of the crate

_NOISE = re.compile(
    r"""//[^\n]*|/\*.*?\*/|r(?P<hash>\#*)".*?"(?P=hash)|b?"(?:\\.|[^"\\])*"|'(?:\\[^']+|[^'\\])'""",
    re.DOTALL,
)
_TEST = re.compile(r"#\[cfg\(test\)\]\s*")
_USE = re.compile(r"(?P<public>\bpub(?:\([^)]*\))?\s+)?\buse\s+(?P<tree>[^;]*);")
_MOD = re.compile(r"\bmod\s+(\w+)\s*;")
_PATH = re.compile(r"(?<![\w:])[A-Za-z_]\w*(?:\s*::\s*[A-Za-z_]\w*)+")


@dataclass
class Module:
    """One source file: its child modules, the names that it imports, the paths that it writes."""

    children: set[str] = field(default_factory=set)
    imported: dict[str, Name] = field(default_factory=dict)  # local name -> path as written
    reexported: set[str] = field(default_factory=set)
    globs: list[Name] = field(default_factory=list)
    paths: set[Name] = field(default_factory=set)
    words: set[str] = field(default_factory=set)


def crate(source: Path) -> dict[Name, Module]:
    """Modules of the crate whose `lib.rs` or `main.rs` lies in `source`, by name."""
    root = source / "lib.rs" if (source / "lib.rs").exists() else source / "main.rs"
    modules: dict[Name, Module] = {}
    waiting: list[tuple[Name, Path]] = [((), root)]
    while waiting:
        name, path = waiting.pop()
        modules[name] = module = parse(path.read_text(encoding="utf-8"))
        for child in sorted(module.children):
            below = source.joinpath(*name, child)
            file = below.with_suffix(".rs")
            waiting.append(((*name, child), file if file.exists() else below / "mod.rs"))
    return modules


def parse(text: str) -> Module:
    """A source file without comments, literals and test code."""
    text = without_tests(_NOISE.sub(" ", text))
    module = Module(children=set(_MOD.findall(text)))
    for match in _USE.finditer(text):
        for path, local in tree(match["tree"]):
            if local == "*":
                module.globs.append(path)
                continue
            module.imported[local] = path
            if match["public"]:
                module.reexported.add(local)
    body = _USE.sub(" ", text)
    module.paths = {tuple(re.split(r"\s*::\s*", segments)) for segments in _PATH.findall(body)}
    module.words = set(re.findall(r"\w+", body))
    return module


def without_tests(text: str) -> str:
    """Cuts the item that follows each `#[cfg(test)]`: to its `;` or to its closing brace."""
    while match := _TEST.search(text):
        end, depth = match.end(), 0
        while end < len(text):
            depth += {"{": 1, "}": -1}.get(text[end], 0)
            end += 1
            if depth == 0 and text[end - 1] in ";}":
                break
        # `use a::{b};` ends at its semicolon
        rest = re.match(r"\s*;", text[end:])
        text = text[: match.start()] + text[end + (rest.end() if rest else 0) :]
    return text


def tree(text: str, before: Name = ()) -> Iterator[tuple[Name, str]]:
    """Path and local name of every leaf of a use tree: `a::{self, b as c, d::*}`."""
    head, brace, inner = text.strip().partition("{")
    path = (*before, *(part.strip() for part in head.split("::") if part.strip()))
    if brace:
        for part in split(inner.rsplit("}", 1)[0]):
            yield from tree(part, path)
        return
    last, _, alias = path[-1].partition(" as ")
    path = (*path[:-1], last.strip())
    if path[-1] == "self" and len(path) > 1:
        path = path[:-1]
    if path[-1] == "*":
        yield path[:-1], "*"
    else:
        yield path, alias.strip() or path[-1]


def split(text: str) -> Iterator[str]:
    """Parts between the commas outside of braces."""
    depth, start = 0, 0
    for k, sign in enumerate(text + ","):
        depth += {"{": 1, "}": -1}.get(sign, 0)
        if sign == "," and depth == 0:
            if text[start:k].strip():
                yield text[start:k]
            start = k + 1


def resolve(
    modules: dict[Name, Module], at: Name, path: Name, seen: frozenset[tuple[Name, str]]
) -> tuple[Name, bool] | None:
    """Module that a path leads to from `at`, and whether it names an item of it, not the module.

    None: the path leads out of the crate, or to something local. `seen`: names on the way, which
    end a re-export that leads back to itself.
    """
    first, rest = path[0], path[1:]
    if first == "crate":
        here: Name = ()
    elif first == "self":
        here = at
    elif first == "super":
        here = at[:-1]
    elif first in modules[at].children and (*at, first) in modules:
        here = (*at, first)
    elif first in modules[at].imported and (at, first) not in seen:
        inner = resolve(modules, at, modules[at].imported[first], seen | {(at, first)})
        if inner is None or inner[1] or not rest:
            return inner
        here = inner[0]
    else:
        return None
    while rest and rest[0] == "super":
        here, rest = here[:-1], rest[1:]
    if not rest:
        return here, False
    if rest[0] in modules[here].children | set(modules[here].imported):
        target = resolve(modules, here, rest, seen)
        if target is not None:
            return target
    return here, True


def dependencies(modules: dict[Name, Module]) -> dict[Name, set[Name]]:
    """Modules whose items each module names, itself left out."""
    graph: dict[Name, set[Name]] = {name: set() for name in modules}
    for name, module in modules.items():
        paths = set(module.paths)
        for local, path in module.imported.items():
            if local not in module.reexported or local in module.words:
                paths.add(path)
        listed = [resolve(modules, name, path, frozenset()) for path in paths]
        listed += [
            (end[0], True)
            for path in module.globs
            if (end := resolve(modules, name, path, frozenset()))
        ]
        graph[name] = {end[0] for end in listed if end and end[1]} - {name}
    return graph


def circles(graph: dict[Name, set[Name]]) -> list[str]:
    """Circles as "a -> b -> a", the first found below each parent module."""
    listed = []
    for parent in sorted({name[:-1] for name in graph if name}):
        siblings: dict[Name, set[Name]] = {}
        for name, targets in graph.items():
            for target in targets:
                a, b = _below(parent, name), _below(parent, target)
                if a is not None and b is not None and a != b:
                    siblings.setdefault(a, set()).add(b)
        if circle := _circle(siblings):
            listed.append(" -> ".join("::".join(("crate", *name)) for name in circle))
    return listed


def _below(parent: Name, name: Name) -> Name | None:
    """The child of `parent` that holds `name`, or `parent`; None where it lies elsewhere."""
    return name[: len(parent) + 1] if name[: len(parent)] == parent else None


def _circle(graph: dict[Name, set[Name]]) -> list[Name]:
    """One circle of a graph, first node repeated at the end; empty where there is none."""
    done: set[Name] = set()

    def visit(node: Name, way: list[Name]) -> list[Name]:
        if node in way:
            return [*way[way.index(node) :], node]
        if node not in done:
            for target in sorted(graph.get(node, ())):
                if circle := visit(target, [*way, node]):
                    return circle
            done.add(node)
        return []

    return next((circle for node in sorted(graph) if (circle := visit(node, []))), [])


def too_long(path: Path) -> bool:
    """Whether a file of more than 250 lines gives no reason ("Long: ...") in its header comment."""
    lines = path.read_text(encoding="utf-8").splitlines()
    if len(lines) <= LONGEST:
        return False
    for line in lines:
        if line.strip() and not line.startswith("//"):
            return True
        if re.search(r"\bLong: \S", line):
            return False
    return True

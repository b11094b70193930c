"""Imports go one way, without circles, by full and public names."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping, Set
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from tests.test_files import tracked

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = {
    "flexhex.fmus": "fmus",
    "flexhex.fmugen": "build/fmugen",
    "flexhex.numeric": "build/numeric",
    "flexhex.ssp": "ssp",
    "flexhex.diagnosis": "diagnosis",
    "flexhex": "flexhex",
}
"""Package -> folder; the first five are links in flexhex/."""
ORDER = (
    "flexhex.fmus.common",
    "flexhex.fmus",
    "flexhex.fmugen",
    "flexhex.numeric",
    "flexhex.ssp",
    "flexhex.diagnosis",
    "flexhex",
)
"""Each may import what stands before it."""


def modules() -> dict[str, Path]:
    """All Python files of the package by module name."""
    paths: dict[str, Path] = {}
    for package, folder in PACKAGES.items():
        for path in sorted((ROOT / folder).rglob("*.py")):
            parts = path.relative_to(ROOT / folder).with_suffix("").parts
            if (ROOT / folder / parts[0]).is_symlink():
                continue
            parts = parts[:-1] if parts[-1] == "__init__" else parts
            paths[".".join([package, *parts])] = path
    return paths


MODULES = modules()


@cache
def tree(path: Path) -> ast.Module:
    """A file, parsed once for all rules."""
    return ast.parse(path.read_text(encoding="utf-8"))


def inner(node: ast.AST) -> Iterator[ast.AST]:
    """What a node holds that may hold an import: statements, never expressions."""
    for field in ("body", "handlers", "cases", "orelse", "finalbody"):
        found = getattr(node, field, ())
        # of a lambda and of `a if b else c` these are expressions
        yield from found if isinstance(found, list) else ()


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """All statements in a node, at any depth."""
    for child in inner(node):
        yield child
        yield from statements(child)


def imported(path: Path, known: Set[str]) -> tuple[set[str], set[str]]:
    """Modules of ours that a file imports: all, and those that it imports while it is loaded.

    An import inside a function happens when it is called; one under TYPE_CHECKING never does.
    """
    every: set[str] = set()
    loading: set[str] = set()

    def visit(node: ast.AST, now: bool) -> None:
        names: set[str] = set()
        if isinstance(node, ast.Import):
            names = {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            parts = {f"{node.module}.{alias.name}" for alias in node.names} & known
            names = parts if len(parts) == len(node.names) else parts | {node.module}
        ours = names & known
        every.update(ours)
        if now:
            loading.update(ours)
        is_function = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        typing_only = isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for child in inner(node):
            visit(child, now and not is_function and not typing_only)

    visit(tree(path), True)
    return every, loading


@cache
def imports() -> dict[str, tuple[set[str], set[str]]]:
    """What each module imports: not read where these tests are only collected."""
    return {name: imported(path, MODULES.keys()) for name, path in MODULES.items()}


def level(module: str) -> int:
    """Place of a module in the order; -1 when it is not ours."""
    inside = [k for k, name in enumerate(ORDER) if f"{module}.".startswith(f"{name}.")]
    return min(inside, default=-1)


def forbidden(module: str, target: str) -> bool:
    """Whether `module` must not import `target`."""
    ours, theirs = level(module), level(target)
    if theirs < 0 or target == "flexhex":
        return False
    if ours == theirs == 1:  # two FMU blocks; machine.fmu is the plant with its truth
        blocks = (module.split(".")[2], target.split(".")[2])
        return blocks[0] != blocks[1] and blocks != ("machine", "plant")
    return theirs > ours


def circle(imports: Mapping[str, set[str]]) -> list[str]:
    """A circle of modules, or nothing."""
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def folders(imports: Mapping[str, set[str]], inside: str) -> dict[str, set[str]]:
    """Imports between the folders (and loose files) directly inside a package."""

    def block(name: str) -> str:
        return ".".join(name.split(".")[: inside.count(".") + 2])

    graph: dict[str, set[str]] = {}
    for name, targets in imports.items():
        if name.startswith(f"{inside}."):
            near = {block(t) for t in targets if t.startswith(f"{inside}.")}
            graph.setdefault(block(name), set()).update(near - {block(name)})
    return graph


@pytest.mark.parametrize("module", MODULES)
def test_imports_go_one_way(module: str) -> None:
    wrong = sorted(name for name in imports()[module][0] if forbidden(module, name))
    assert not wrong, f"{module} imports {', '.join(wrong)}"


def test_the_rule_forbids_what_it_should() -> None:
    assert forbidden("flexhex.fmus.plant.step", "flexhex.fmus.filter.equations")
    assert forbidden("flexhex.fmus.common.model", "flexhex.fmus.plant.equations")
    assert forbidden("flexhex.fmus.plant.equations", "flexhex.fmus.machine.truth")
    assert forbidden("flexhex.ssp.read", "flexhex.cli")
    assert not forbidden("flexhex.cli", "flexhex.ssp.read")
    assert not forbidden("flexhex.fmus.plant.equations", "flexhex.fmus.common.model")


def test_no_module_imports_itself_in_a_circle() -> None:
    """Also through imports inside functions: those only hide a circle."""
    assert circle({name: every for name, (every, _) in imports().items()}) == []


def test_no_folders_import_each_other_in_a_circle() -> None:
    every = {name: targets for name, (targets, _) in imports().items()}
    packages = sorted({name.rpartition(".")[0] for name in MODULES} - {""})
    circles = {package: circle(folders(every, package)) for package in packages}
    assert {package: names for package, names in circles.items() if names} == {}


def test_circles_are_seen() -> None:
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"a"}})
    assert not circle({"a": {"b"}, "b": {"c"}})
    graph = {"p.x.one": {"p.y.one"}, "p.y.two": {"p.x.two"}, "p.x.two": set(), "p.y.one": set()}
    assert circle(folders(graph, "p")), "two folders, although no two modules"


def test_everything_goes_by_its_full_name() -> None:
    """`import fmus` works in a checkout, and would load every class a second time."""
    short = {name.removeprefix("flexhex.").split(".")[0] for name in PACKAGES} - {"flexhex"}
    # a file where no such name stands without a package before it need not be parsed
    loose = re.compile(rf"(?<!\w\.)\b(?:{'|'.join(sorted(short))})\b")
    wrong = []
    for path in (p for p in tracked() if p.suffix == ".py"):
        if not loose.search(path.read_text(encoding="utf-8")):
            continue
        for node in statements(tree(path)):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [a.name for a in node.names] if isinstance(node, ast.Import) else []
            wrong += [f"{path.relative_to(ROOT)}: {n}" for n in names if n.split(".")[0] in short]
    assert wrong == []


def private_names(path: Path) -> list[str]:
    """Names with a leading underscore that a file imports."""
    wrong = []
    for node in statements(tree(path)):
        if isinstance(node, ast.ImportFrom):
            names = [*(node.module or "").split("."), *(alias.name for alias in node.names)]
            wrong += [n for n in names if n.startswith("_") and not n.startswith("__")]
    return wrong


def test_nobody_imports_a_private_name() -> None:
    by_name = {name: private_names(path) for name, path in MODULES.items()}
    assert {name: names for name, names in by_name.items() if names} == {}


def test_private_names_are_seen(tmp_path: Path) -> None:
    path = tmp_path / "x.py"
    path.write_text("from __future__ import annotations\nfrom a._b import c\nfrom a import _d\n")
    assert private_names(path) == ["_b", "_d"]


def test_links_of_the_package_lead_to_the_folders_on_top() -> None:
    links = {path.name: path for path in (ROOT / "flexhex").iterdir() if path.is_symlink()}
    wanted = {name.removeprefix("flexhex."): folder for name, folder in PACKAGES.items()}
    wanted = {name: folder for name, folder in wanted.items() if name != "flexhex"}
    wanted |= {"runtime": "build/runtime", "machines": "machines"}
    assert {name: path.resolve() for name, path in links.items()} == {
        name: ROOT / folder for name, folder in wanted.items()
    }
    assert all(not path.readlink().is_absolute() for path in links.values())

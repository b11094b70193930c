"""What pyproject.toml makes every user install is what the package imports, and nothing else."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from pathlib import Path

from tests.conftest import ROOT
from tests.test_house import MODULES

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
ON_REQUEST = {"distributed", "pyarrow", "asammdf"}
"""Imported where they are installed: extras of their own, which a message names."""


def distribution(requirement: str) -> str:
    """`casadi` of `casadi>=3.7`."""
    return re.split(r"[<>=~!;\[ ]", requirement)[0].lower()


def imports(path: Path) -> set[str]:
    """First words of all modules that a file imports, also inside functions."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.partition(".")[0])
    return names - set(sys.stdlib_module_names) - {"flexhex"}


def test_dependencies_are_what_the_package_imports() -> None:
    declared = {distribution(requirement) for requirement in PROJECT["dependencies"]}
    needed = set().union(*map(imports, MODULES.values())) - ON_REQUEST
    assert needed - declared <= {"markupsafe"}, "markupsafe is a part of jinja2"
    assert declared - needed == set(), "imported nowhere in the package: belongs to an extra"


def test_locked_dependencies_hold_nothing_that_only_tests_import() -> None:
    locked = {
        distribution(line)
        for line in (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()
        if line[:1].isalpha()
    }
    assert {distribution(requirement) for requirement in PROJECT["dependencies"]} <= locked
    assert not locked & {"control", "matplotlib", "mujoco", "pytest"}

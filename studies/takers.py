"""Who takes a number of the diagnosis from the module that has it."""

from __future__ import annotations

import ast
import importlib
from functools import lru_cache
from pathlib import Path
from pkgutil import walk_packages
from types import ModuleType


@lru_cache
def takers(home: str, name: str) -> list[ModuleType]:
    """The module of a number, and all of the diagnosis that import it from there by its name."""
    package = importlib.import_module("flexhex.diagnosis")
    found = [importlib.import_module(home)]
    for info in walk_packages(package.__path__, f"{package.__name__}."):
        module = importlib.import_module(info.name)
        source = Path(str(module.__file__)).read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.ImportFrom) and node.module == home:
                found += [module] * any(alias.name == name for alias in node.names)
    return found

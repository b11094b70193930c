"""The public interface: the examples of docs/api.md run, user code is typed, imports are light."""

from __future__ import annotations

import importlib
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import flexhex
from flexhex import api
from tests.conftest import ROOT

PAGE = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
HEAVY = ("casadi", "scipy", "numpy", "fmpy", "h5py", "lxml", "jinja2", "control", "pydantic")
SCRIPT = """
import flexhex

machine: flexhex.Machine = flexhex.load_machine(flexhex.machine_file())
built: flexhex.Build = flexhex.build_model(out="out")
result: flexhex.Result = flexhex.simulate_system(built.model, 1.0, signals=["K.p"])
peak: float = float(abs(result["feedback.e"]).max())
fit: flexhex.Fit = flexhex.identify_parameters(machine, [flexhex.read_log("a.csv")])
found: flexhex.Identified = flexhex.identify_runs(["a.csv"], base="axis")
diagnosis: flexhex.Diagnosis = flexhex.diagnose_runs(["a.csv"], machine="m.toml")
same: bool = flexhex.compare_results(result, flexhex.load_result("b.h5")).equal
try:
    flexhex.save_result(result, "c.h5")
except flexhex.FlexhexError as error:
    print(error, flexhex.__version__, peak, same, fit.p, diagnosis.verdict)
"""


def python(*words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """This interpreter with this checkout, in a folder of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "MYPYPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, *words], cwd=cwd, env=environment, capture_output=True, text=True
    )


@pytest.mark.usefixtures("builder")
def test_examples_of_the_page_run_in_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The FMUs come out of the cache that the other tests of this session fill."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    blocks = re.findall(r"^```python\n(.*?)^```", PAGE, flags=re.MULTILINE | re.DOTALL)
    assert len(blocks) >= 8
    for block in blocks:
        exec(compile(block, "docs/api.md", "exec"), names)
    assert flexhex.compare_results(names["result"], names["again"]).equal
    assert not names["comparison"].equal, "another plant"
    assert [effect.id for effect in names["diagnosis"].effects] == ["coulomb_friction"]
    printed = capsys.readouterr().out
    for k, name in enumerate(names["names"][:3]):
        loose = name in names["fit"].undetermined
        shown = "not determined" if loose else f"{names['fit'].p[k]:.4f} +- "
        assert f"\n{name} {shown}" in printed, "an estimate without its deviation says nothing"


def test_page_names_every_public_name() -> None:
    missing = [n for n in flexhex.__all__ if n != "__version__" and f"`{n}" not in PAGE]
    assert missing == []


def test_public_names_are_those_of_the_api() -> None:
    assert [*api.__all__, "__version__"] == sorted(flexhex.__all__, key=api_order)
    assert dir(flexhex) == flexhex.__all__
    for name in api.__all__:
        assert getattr(flexhex, name) is getattr(api, name)
    with pytest.raises(AttributeError, match="module 'flexhex' has no attribute 'nothing'"):
        flexhex.nothing  # noqa: B018


def api_order(name: str) -> tuple[bool, str]:
    """`__version__` last."""
    return name.startswith("_"), name


def test_every_public_function_says_what_it_does_with_an_example() -> None:
    listed = [getattr(flexhex, name) for name in api.__all__ if name.islower()]
    assert len(listed) >= 10
    assert [f.__name__ for f in listed if ">>> " not in (f.__doc__ or "")] == []


def test_a_user_script_is_typed(tmp_path: Path) -> None:
    wrong = SCRIPT.replace("built: flexhex.Build", "built: flexhex.Fit")
    for name, text in (("right.py", SCRIPT), ("wrong.py", wrong)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    mypy = ("-m", "mypy", "--strict", "--follow-imports=silent", "--no-incremental")
    config = ("--config-file", str(ROOT / "pyproject.toml"))
    done = python(*mypy, *config, "right.py", "wrong.py", cwd=tmp_path)
    errors = [line for line in done.stdout.splitlines() if ": error: " in line]
    assert {line.split(":")[0] for line in errors} == {"wrong.py"}, done.stdout + done.stderr
    assert 'expression has type "Build", variable has type "Fit"' in errors[0]


LOADED = "import sys; print([m for m in {heavy!r} if m in sys.modules])"


@pytest.mark.parametrize(
    "code",
    [
        "import flexhex",
        "import flexhex.cli as c; c.app(['--version'], standalone_mode=False)",
        "import flexhex.cli as c; c.app(['--help'], standalone_mode=False)",
    ],
)
def test_start_loads_nothing_heavy(code: str, tmp_path: Path) -> None:
    done = python("-c", f"{code}\n{LOADED.format(heavy=HEAVY)}", cwd=tmp_path)
    assert done.stdout.splitlines()[-1:] == ["[]"], done.stdout + done.stderr


def test_version_has_one_source() -> None:
    assert flexhex.__version__ == importlib.import_module("flexhex.fmugen").VERSION
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert 'dynamic = ["version"]' in text
    assert 'path = "flexhex/fmugen/__init__.py"' in text


def test_checkout_without_links_says_how_to_mend_it(tmp_path: Path) -> None:
    """As git writes a checkout where it may not make links: files that hold the link's target."""
    package = tmp_path / "flexhex"
    package.mkdir()
    text = (ROOT / "flexhex" / "__init__.py").read_text(encoding="utf-8")
    (package / "__init__.py").write_text(text, encoding="utf-8")
    (package / "fmus").write_text("../fmus", encoding="utf-8")
    command = [sys.executable, "-c", "import flexhex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith("ImportError: ")
    assert str(package / "fmus") in last
    assert "git config core.symlinks true" in last
    assert "git checkout HEAD -- flexhex" in last


def test_links_survive_an_archive_of_the_repository(tmp_path: Path) -> None:
    archive = subprocess.run(["git", "archive", "HEAD", "flexhex"], cwd=ROOT, capture_output=True)
    if archive.returncode:
        pytest.skip("not a git checkout")
    subprocess.run(["tar", "x", "-C", str(tmp_path)], input=archive.stdout, check=True)
    links = [path.name for path in (ROOT / "flexhex").iterdir() if path.is_symlink()]
    assert len(links) == 7
    for name in links:
        link = tmp_path / "flexhex" / name
        assert link.is_symlink()
        assert link.readlink() == (ROOT / "flexhex" / name).readlink()

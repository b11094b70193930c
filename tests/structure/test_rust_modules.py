"""The Rust crates have no circular imports and no long files without a reason."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.structure.rust_modules import (
    LONGEST,
    circles,
    crate,
    dependencies,
    parse,
    too_long,
    without_tests,
)

GATEWAY = Path(__file__).resolve().parents[2] / "gateway"
CRATES = ("src", "emulator/src", "system/src")


def written(folder: Path, files: dict[str, str]) -> Path:
    """Source files of a made crate."""
    for name, text in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    return folder


def circles_of(folder: Path, files: dict[str, str]) -> list[str]:
    return circles(dependencies(crate(written(folder, files))))


@pytest.mark.parametrize("source", CRATES)
def test_crates_have_no_circular_imports(source: str) -> None:
    modules = crate(GATEWAY / source)
    assert len(modules) > 10, "the source files were not found"
    assert circles(dependencies(modules)) == []


def test_dependencies_are_found_as_written() -> None:
    graph = dependencies(crate(GATEWAY / "src"))
    # through a re-export (bus::Difference), an alias (bus::inspect), a nested use, a sibling
    assert {("bus", "difference"), ("bus", "setup"), ("session",), ("exit",)} <= graph[("check",)]
    assert ("bus",) not in graph[("check",)]
    assert ("rules",) in graph[("safety",)]


@pytest.mark.parametrize(
    ("files", "circle"),
    [
        (
            {
                "lib.rs": "mod a;\nmod b;\n",
                "a.rs": "use crate::b::B;\npub struct A(B);\n",
                "b.rs": "pub struct B;\npub fn f() { let _: Option<crate::a::A> = None; }\n",
            },
            "crate::a -> crate::b -> crate::a",
        ),
        (
            {
                "main.rs": "mod a;\npub struct Root;\nfn main() { a::run(); }\n",
                "a.rs": "use super::Root;\npub fn run() { let _ = Root; }\n",
            },
            "crate -> crate::a -> crate",
        ),
        (
            # two folders, though no two files form a circle
            {
                "lib.rs": "mod a;\nmod b;\n",
                "a/mod.rs": "mod data;\npub use data::Data;\nuse crate::b::B;\npub struct A(B);\n",
                "a/data.rs": "pub struct Data;\n",
                "b/mod.rs": "use crate::a::{self, Data};\npub struct B(Data);\n",
            },
            "crate::a -> crate::b -> crate::a",
        ),
        (
            {
                "lib.rs": "mod top;\n",
                "top/mod.rs": "mod a;\nmod b;\n",
                "top/a.rs": "use super::b;\npub fn f() { b::g(); }\n",
                "top/b.rs": "pub fn g() {}\npub fn h() { super::a::f(); }\n",
            },
            "crate::top::a -> crate::top::b -> crate::top::a",
        ),
    ],
    ids=["files", "root", "folders", "siblings"],
)
def test_a_circle_is_found_and_named(tmp_path: Path, files: dict[str, str], circle: str) -> None:
    assert circles_of(tmp_path, files) == [circle]


def test_facades_comments_and_tests_form_no_circle(tmp_path: Path) -> None:
    files = {
        "lib.rs": "mod a;\npub use a::f;\n",
        "a/mod.rs": "mod b;\npub use b::f;\npub struct A;\n",
        "a/b.rs": (
            'use super::A;\n// crate::f\npub fn f() -> A { let _ = "crate::f()"; A }\n'
            "#[cfg(test)]\nmod tests {\n    use crate::a::f;\n    fn t() { f(); }\n}\n"
        ),
    }
    assert circles_of(tmp_path, files) == []


def test_test_code_is_cut_to_the_end_of_its_item() -> None:
    text = "a;\n#[cfg(test)]\nuse b::{c, d};\n#[cfg(test)]\nmod t { fn f() { {} } }\ne::f();"
    assert without_tests(text).split() == ["a;", "e::f();"]
    assert parse("fn f<'a>(c: char) { c == '{'; x::y(); }").paths == {("x", "y")}


def test_rust_files_are_short_or_say_why_not() -> None:
    files = [p for p in sorted(GATEWAY.rglob("*.rs")) if "target" not in p.parts]
    assert len(files) > 50, "the source files were not found"
    long = [str(p.relative_to(GATEWAY)) for p in files if too_long(p)]
    assert long == [], f"more than {LONGEST} lines: split it or add a header line `//! Long: why`"


def test_a_long_file_needs_its_reason_in_the_header(tmp_path: Path) -> None:
    file, line = tmp_path / "a.rs", "fn f() {}\n"
    for text, wanted in [
        (line * LONGEST, False),
        (line * (LONGEST + 1), True),
        ("//! A.\n//! Long: one table.\n" + line * LONGEST, False),
        ("//! A.\n//! Long:\n" + line * LONGEST, True),
        (line * LONGEST + "// Long: too late to be seen.\n", True),
    ]:
        file.write_text(text, encoding="utf-8")
        assert too_long(file) is wanted

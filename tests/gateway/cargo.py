"""Rust binaries of gateway/, built on first use; tests skip with the reason where cargo cannot."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from functools import lru_cache
from pathlib import Path

import pytest

from tests.conftest import ROOT, one_at_a_time

GATEWAY = ROOT / "gateway"
TARGET = GATEWAY / os.environ.get("CARGO_TARGET_DIR", "target")
"""Where cargo builds; it reads the same variable."""


@lru_cache
def need_cargo() -> None:
    """Skips without cargo, or where it cannot get the crates; writes Cargo.lock."""
    if shutil.which("cargo") is None:
        pytest.skip("no cargo on the PATH")
    with one_at_a_time(TARGET):
        for command in ([sys.executable, "lock.py", "write"], ["cargo", "fetch", "--locked"]):
            done = subprocess.run(command, cwd=GATEWAY, capture_output=True, text=True)
            if done.returncode:
                pytest.skip(f"cargo cannot get the crates: {done.stderr.strip()[-300:]}")


def cargo(*arguments: str, **more: str) -> subprocess.CompletedProcess[str]:
    """Runs cargo in gateway/ (one test process at a time) with more environment."""
    need_cargo()
    with one_at_a_time(TARGET):
        command = ["cargo", *arguments, "--release", "--locked"]
        env = {**os.environ, **more}
        return subprocess.run(command, cwd=GATEWAY, env=env, capture_output=True, text=True)


@lru_cache
def built() -> Path:
    """Builds all programs, as `make programs` does, and returns cargo's folder."""
    done = cargo("build", "--workspace", "--bins", "--examples")
    assert done.returncode == 0, done.stderr
    return TARGET / "release"

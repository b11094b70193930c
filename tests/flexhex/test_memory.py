"""Arrays of a command take the memory of those that it has freed."""

from __future__ import annotations

import ctypes
import subprocess
import sys

PROGRAM = """
import resource
import sys

import numpy as np

if "keep" in sys.argv:
    from flexhex.numeric.memory import keep

    keep()


def pages():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt


def work():
    values = np.ones(300_000)  # 2.4 MB
    return float((values + 1).sum())


work()
begin = pages()
for _ in range(20):
    work()
print(pages() - begin)
"""


def fresh_pages(*arguments: str) -> int:
    command = [sys.executable, "-c", PROGRAM, *arguments]
    return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def test_freed_memory_is_used_again() -> None:
    kept = fresh_pages("keep")
    if hasattr(ctypes.CDLL(None), "mallopt"):
        assert kept < 100 < fresh_pages() / 10

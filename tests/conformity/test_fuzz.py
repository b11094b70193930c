"""Random calls with random arguments under AddressSanitizer and UBSan: nothing is found.

`make fuzz` makes 1e6 calls on each FMU; here is a sample, and that the fuzzer does find.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from flexhex.fmugen.blocks import BLOCKS
from tests.conformity.archives import members, text, write
from tests.conformity.fuzz import fuzz, has_sanitizers

SAMPLE = 20_000


@pytest.fixture(scope="module", autouse=True)
def _sanitizers(tmp_path_factory: pytest.TempPathFactory) -> None:
    if not has_sanitizers(tmp_path_factory.mktemp("probe")):
        pytest.skip("the compiler has no sanitizers")


def test_random_calls_of_the_toy_find_nothing(toy: Path) -> None:
    done = fuzz(toy, 10 * SAMPLE)
    assert done.returncode == 0, done.stdout + done.stderr[-2000:]
    words = done.stdout.split()
    assert int(words[1]) == 10 * SAMPLE
    # neither mostly refused nor hardly ever
    assert 0.1 < int(words[3]) / int(words[1]) < 0.7


@pytest.mark.parametrize("name", ["feedback", "kinematics"])
def test_random_calls_find_nothing(fmu_dir: Path, name: str) -> None:
    done = fuzz(fmu_dir / f"{name}.fmu", SAMPLE, seed=2)
    assert done.returncode == 0, done.stdout + done.stderr[-2000:]


@pytest.mark.slow
@pytest.mark.parametrize("name", [*BLOCKS, "machine"])
def test_a_million_random_calls_find_nothing(fmu_dir: Path, name: str) -> None:
    done = fuzz(fmu_dir / f"{name}.fmu", 1_000_000, seed=3)
    assert done.returncode == 0, done.stdout + done.stderr[-2000:]


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    ("member", "old", "new", "says"),
    [
        ("values.c", "if (vr >= m->n_values)", "if (vr > m->n_values + 7)", "ERROR|broken"),
        ("values.c", "if (!(value >= low && value <= high))", "if (0)", "broken answer"),
        ("values.c", "if (variable_of(m, vr)->type != type) {", "if (0) {", "broken|ERROR"),
        ("values.c", "if (!may_set(m, v)) {", "if (0) {", "broken"),
        ("instance.h", '"fmi2Terminate", C)', '"fmi2Terminate", C | T)', "broken answer"),
        ("states.c", 'return memcmp(&e, &wanted, sizeof e) == 0', "return 1", "broken serialised"),
        ("messages.c", "m->head->refused = 1;", "m->values[0] += 1e-6;", "broken"),
        ("advance.c", "whole >= 0.0 && whole < MOST_STEPS", "1", "runtime error|broken"),
        ("advance.c", "fabs(count - whole) <= slack(m, whole)", "1", "broken answer"),
    ],
)  # fmt: skip
def test_fuzzer_finds(
    toy: Path, tmp_path: Path, member: str, old: str, new: str, says: str
) -> None:
    files = members(toy)
    text(old, new, f"sources/{member}")(files)
    done = fuzz(write(tmp_path / "toy.fmu", files), 10 * SAMPLE)
    assert done.returncode != 0
    said = done.stdout + done.stderr
    assert any(part in said for part in says.split("|")), said[-2000:]

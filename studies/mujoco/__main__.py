"""`python -m studies.mujoco --seed N --out FOLDER [--category C] [--kind K] [--effect ID]
[--test]`: a case's logs and machine file in FOLDER/logs, its truth in FOLDER/sealed."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from studies.mujoco.draw import SHARES
from studies.mujoco.inside import MAKERS
from studies.mujoco.machines import KINDS
from studies.mujoco.make import make
from studies.mujoco.outside import MAKERS as OUTSIDE


def main(arguments: list[str] | None = None) -> int:
    """0; ends with a message for what cannot be."""
    parser = argparse.ArgumentParser(prog="studies.mujoco", description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--category", choices=list(SHARES))
    parser.add_argument("--kind", choices=list(KINDS))
    parser.add_argument("--effect", choices=[*MAKERS, *OUTSIDE])
    parser.add_argument("--test", action="store_true", help="allow seeds of the tests")
    given = parser.parse_args(arguments)
    try:
        written = make(
            given.seed,
            given.out / "logs",
            given.out / "sealed",
            category=given.category,
            kind=given.kind,
            effect=given.effect,
            test=given.test,
        )
    except ValueError as error:
        parser.error(str(error))
    files = {
        "logs": [str(path) for path in written.paths],
        "test": [str(path) for path in written.test_paths],
        "machine_file": str(written.machine_file),
        "sealed": str(written.sealed),
    }
    print(json.dumps(files, indent=1))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

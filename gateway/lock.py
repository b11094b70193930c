"""Cargo.lock without addresses: `crates.lock` holds names, versions, checksums and who needs whom.

    python gateway/lock.py write    # crates.lock -> Cargo.lock; then `cargo build --locked`
    python gateway/lock.py save     # Cargo.lock -> crates.lock, after a change of dependencies

Where the crates come from is cargo's own configuration: the one line that is left out, `source`,
is taken from a Cargo.lock that cargo makes here.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
CARGO, OURS = HERE / "Cargo.lock", HERE / "crates.lock"
_SOURCE = re.compile(r'^source = ".*"\n', re.MULTILINE)
_CHECKSUM = re.compile(r"^checksum = ", re.MULTILINE)
_PROBE = (
    '[package]\nname = "probe"\nversion = "0.0.0"\nedition = "2021"\n[dependencies]\ncc = "1"\n'
)


def save() -> None:
    """Writes crates.lock; every crate from elsewhere must have a checksum."""
    text = CARGO.read_text(encoding="utf-8")
    if len(_SOURCE.findall(text)) != len(_CHECKSUM.findall(text)):
        sys.exit(f"{CARGO}: a crate has no checksum: use crates of a registry only")
    OURS.write_text(_SOURCE.sub("", text), encoding="utf-8")


def write() -> None:
    """Writes Cargo.lock unless it says the same already."""
    wanted = OURS.read_text(encoding="utf-8")
    if CARGO.exists() and _SOURCE.sub("", CARGO.read_text(encoding="utf-8")) == wanted:
        return
    source = registry()
    CARGO.write_text(_CHECKSUM.sub(f"{source}checksum = ", wanted), encoding="utf-8")


def registry() -> str:
    """The line `source = ...` as cargo writes it for its default registry."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        (root / "src").mkdir()
        (root / "src" / "lib.rs").touch()
        (root / "Cargo.toml").write_text(_PROBE, encoding="utf-8")
        done = subprocess.run(
            ["cargo", "generate-lockfile"], cwd=root, capture_output=True, text=True, check=False
        )
        if done.returncode:
            sys.exit(f"cargo cannot ask its registry:\n{done.stderr.strip()}")
        match = _SOURCE.search((root / "Cargo.lock").read_text(encoding="utf-8"))
    if match is None:
        sys.exit("cargo wrote a Cargo.lock without a source")
    return match[0]


if __name__ == "__main__":
    actions = {"write": write, "save": save}
    if len(sys.argv) != 2 or sys.argv[1] not in actions:
        sys.exit(f"usage: python {sys.argv[0]} write|save")
    actions[sys.argv[1]]()

"""The systemd unit: a run under what it may write, and no more."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from configparser import ConfigParser
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.gateway.bench import Bench, Ran
from tests.gateway.cargo import GATEWAY

UNIT = GATEWAY / "flexhex-gateway.service"


def service() -> dict[str, str]:
    """Its section [Service], the last of each key."""
    unit = ConfigParser(strict=False, interpolation=None)
    unit.optionxform = str  # type: ignore[assignment,method-assign]
    unit.read_string(UNIT.read_text())
    return dict(unit["Service"])


@pytest.fixture
def state(request: pytest.FixtureRequest) -> Iterator[Path]:
    """A folder in the place of the state directory, not below /tmp."""
    folder = ROOT / "out" / "test" / f"service-{abs(hash(request.node.name))}"
    folder.mkdir(parents=True)
    yield folder
    shutil.rmtree(folder)


def confined(ssp: Path, state: Path, section: dict[str, str]) -> Ran:
    """A short run as systemd would start it: all is read-only but the state directory and /tmp, if
    that is private."""
    assert section["ProtectSystem"] == "strict"
    assert section["WorkingDirectory"] == f"%S/{section['StateDirectory']}"
    private = section.get("PrivateTmp") == "true"
    script = "\n".join([
        "mount --make-rprivate /",
        f"mount --bind {state} {state}",
        "mount -t tmpfs none /tmp" if private else "mount --bind /tmp /tmp",
        "" if private else "mount -o remount,bind,ro /tmp",
        "mount -o remount,bind,ro /",
        f"cd {state}",
        'exec "$@"',
    ])  # fmt: skip
    wrapper = ("unshare", "--mount", "sh", "-ec", script, "sh")
    relative = ('folder = "../../out/runs"', 'folder = "runs"')
    return Bench(ssp, state).run(seconds=0.05, wrapper=wrapper, changes=(relative,))


def test_run_under_the_unit_finds_all_that_it_writes(hexapod_ssp: Path, state: Path) -> None:
    ran = confined(hexapod_ssp, state, service())
    assert ran.code == 0, ran.words
    assert len(ran.table["time"]) > 0


def test_unit_without_a_temporary_folder_is_refused(hexapod_ssp: Path, state: Path) -> None:
    """What the unit was before: the FMUs have no place."""
    ran = confined(hexapod_ssp, state, service() | {"PrivateTmp": "false"})
    assert ran.code == 3, ran.words
    assert "Read-only file system" in ran.one("refused")["message"]


def test_an_end_of_the_service_lands_and_nothing_starts_it_again() -> None:
    section = service()
    assert section["KillSignal"] == "SIGINT"
    assert section["Restart"] == "no"
    assert " off " in section["ExecStopPost"]
    assert "[Install]" not in UNIT.read_text().replace("no [Install] section", "")

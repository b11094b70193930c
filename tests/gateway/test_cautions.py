"""Stops worse than the fault are told where they are chosen."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.gateway.cargo import GATEWAY, built


def warnings(ssp: Path, *changes: str, code: int = 1) -> str:
    """What `check` says of the template with these changes; it ends where no interface is."""
    command = [built() / "flexhex-gateway", "check", GATEWAY / "machines" / "akd.toml"]
    sets = [word for change in changes for word in ("--set", change)]
    words = [*command, "--ssp", ssp, "--interface", "none", *sets]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == code, done.stdout
    return done.stdout


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ("reactions.jump=land", "trusts the encoder that has just failed"),
        ("reactions.drive_fault=land", "does not obey cannot land"),
        ("reactions.lost_frames=damp", "does not obey cannot land"),
    ],
)
def test_landing_without_what_it_needs_is_reported(
    change: str, why: str, hexapod_ssp: Path
) -> None:
    assert why in warnings(hexapod_ssp, change)


def test_template_is_cautioned_for_what_only_the_lab_knows(hexapod_ssp: Path) -> None:
    """Serial numbers of the drives, and where the machine rests."""
    text = warnings(hexapod_ssp)
    assert text.count("caution") == 2
    assert "it is not known where the machine rests" in text
    assert "axes [1, 2, 3, 4, 5, 6] accept any drive" in text


def test_landing_without_a_gain_is_refused(hexapod_ssp: Path) -> None:
    text = warnings(hexapod_ssp, 'system.parameters={"feedback.kp[3]"=0.0}', code=3)
    assert "feedback.kp[3] = 0, must be above 0" in text

"""Emergency messages in the mailbox of a drive, and a drive that does not say its state."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.gateway.bench import Bench, drive

SOME = "".join(drive(k, "emergencies = 5") for k in range(6))
"""Every fifth request is answered after an emergency message."""
MUTE = drive(2, 'objects = [{ object = 0x6041, value = 0, access = "absent" }]')


@pytest.mark.parametrize("command", [("run", "--enable", "--lockstep"), ("check", "--bus")])
def test_emergency_message_in_the_place_of_an_answer_changes_nothing(
    command: tuple[str, ...], hexapod_ssp: Path, tmp_path: Path
) -> None:
    """ethercrab panics at one: the mailbox is read again."""
    ran = Bench(hexapod_ssp, tmp_path).run(options=SOME, command=command, seconds=0.1)
    assert ran.code == 0, ran.words
    assert "panicked" not in ran.words


def test_off_does_not_say_that_a_drive_is_without_power_that_did_not_say_so(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    ran = Bench(hexapod_ssp, tmp_path).run(options=MUTE, command=("off",))
    assert ran.code == 1, ran.words
    message = ran.one("refused")["message"]
    assert message.startswith("not known to be without power: position 2: no answer")

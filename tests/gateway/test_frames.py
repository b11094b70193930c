"""The gateway's own frames before an independent decoder: from the first to the last."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.gateway.bench import Bench
from tests.gateway.decoder import decode, malformed, need_tshark

CYCLES = 1000
PROCESS_DATA = {"0x0a", "0x0b", "0x0c"}
"""Logical read, write, both: the first datagram of a cycle."""
AT_THE_END = ["0x0120"] * 2 + ["0x0300"] * 6 + ["0x0120"]
"""AL control, error counters."""
OURS, BACK = "ecat && eth.src[0] == 10", "ecat && eth.src[0] == 12"
"""What the gateway sends; the first drive sets a bit there on the way back. (The kernel's own
frames, router solicitations, may have such an address too: it is drawn.)"""


def decode_fields(capture: Path, name: str, kept: str) -> list[str]:
    """A field of tshark in each of the frames that are kept; of several datagrams, with commas."""
    return decode(capture, "-Y", kept, "-T", "fields", "-e", name)


@pytest.mark.parametrize("kind", ["akd", pytest.param("cia402", marks=pytest.mark.slow)])
def test_every_frame_of_a_run_is_sound(kind: str, hexapod_ssp: Path, tmp_path: Path) -> None:
    need_tshark()
    capture = tmp_path / "run.pcapng"
    bench = Bench(hexapod_ssp, tmp_path, kind)
    ran = bench.run(seconds=CYCLES * 0.00025, capture=capture)
    assert ran.code == 0, ran.words
    frames = decode(capture, "-Y", "eth.type == 0x88a4")
    assert len(decode(capture, "-Y", "ecat")) == len(frames), "each is decoded as EtherCAT"
    assert malformed(capture) == []
    # all parts of a run are among them, there and back: the maps, each cycle, the way out
    maps = {"0x1c12", "0x1c13"}
    for end in (OURS, BACK):
        assert maps <= set(decode_fields(capture, "ecat_mailbox.coe.sdoidx", end))
        commands = decode_fields(capture, "ecat.cmd", end)
        cycles = [one for one in commands if one.split(",")[0] in PROCESS_DATA]
        assert len(cycles) >= CYCLES
        # SAFE-OP and PRE-OP to all, the counters of the cables of six drives, INIT to all
        assert commands[-9:] == ["0x08"] * 2 + ["0x04"] * 6 + ["0x08"]
        assert decode_fields(capture, "ecat.ado", end)[-9:] == AT_THE_END

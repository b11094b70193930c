"""`esi`: the profile of an unknown drive, from its maker's file to a run."""

from __future__ import annotations

import subprocess
from pathlib import Path

from tests.gateway.bench import Bench
from tests.gateway.cargo import GATEWAY, built

RX = (("#x6040", 16), ("#x6060", 8), ("0", 8), ("#x6071", 16))
TX = (("#x6041", 16), ("#x6061", 8), ("0", 8), ("#x6064", 32), ("#x6077", 16))


def esi(code: str = "#x04020010") -> str:
    """The file of the emulated CiA 402 drive."""

    def pdo(tag: str, index: str, sm: int, entries: tuple[tuple[str, int], ...]) -> str:
        inside = "".join(
            f"<Entry><Index>{at}</Index><BitLen>{bits}</BitLen></Entry>" for at, bits in entries
        )
        return f'<{tag} Sm="{sm}"><Index>{index}</Index>{inside}</{tag}>'

    device = f'<Type ProductCode="{code}" RevisionNo="#x2">CST</Type>'
    device += pdo("RxPdo", "#x1600", 2, RX) + pdo("TxPdo", "#x1A00", 3, TX)
    vendor = "<Vendor><Id>3870</Id></Vendor>"
    devices = f"<Descriptions><Devices><Device>{device}</Device></Devices></Descriptions>"
    return f"<EtherCATInfo>{vendor}{devices}</EtherCATInfo>"


def profile_of(file: Path, *more: str) -> subprocess.CompletedProcess[str]:
    """The command `esi`."""
    program = built() / "flexhex-gateway"
    return subprocess.run([program, "esi", file, *more], capture_output=True, text=True)


def test_unknown_drive_runs_with_the_profile_of_its_file(hexapod_ssp: Path, tmp_path: Path) -> None:
    file = tmp_path / "drive.xml"
    file.write_text(esi())
    printed = profile_of(file)
    assert printed.returncode == 0, printed.stderr
    known = printed.stdout.replace(
        "counts_per_revolution = 0.0", "counts_per_revolution = 4294967296.0"
    )
    known = known.replace("rated_torque_N_m = 0.0 }", "rated_torque_N_m = 9.0 }")
    text = (GATEWAY / "machines" / "cia402.toml").read_text()
    old = text[text.index("[profile]") : text.index("[limits]")]
    ran = Bench(hexapod_ssp, tmp_path, "cia402").run(seconds=0.25, changes=((old, known + "\n"),))
    assert ran.code == 0, ran.words


def test_file_that_is_none_and_choice_that_is_open_are_reported(tmp_path: Path) -> None:
    file = tmp_path / "drive.xml"
    file.write_text("<a/>")
    printed = profile_of(file)
    assert (printed.returncode, printed.stdout) == (3, "")
    assert "its root is <a>" in printed.stderr
    device = esi()[esi().index("<Device>") : esi().index("</Devices>")]
    file.write_text(esi().replace(device, device + device.replace("#x04020010", "#x1")))
    printed = profile_of(file)
    assert printed.returncode == 3
    assert "choose one device by --product:\n  0x04020010 CST\n  0x00000001 CST" in printed.stderr
    assert profile_of(file, "--product", "1").returncode == 0

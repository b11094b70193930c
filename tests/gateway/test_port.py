"""Two gateways on a port, a port that is down, rights that are missing."""

from __future__ import annotations

import subprocess
from pathlib import Path

from tests.gateway.bench import Bench
from tests.gateway.test_refusals import RUN, when_running


def test_second_gateway_on_a_port_is_refused_and_harms_nothing(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    second: list[subprocess.CompletedProcess[str]] = []

    def start(pid: int) -> None:
        config = tmp_path / "machine.toml"
        words = [f"/proc/{pid}/exe", "check", config, "--bus", "--interface", "bus1"]
        inside = ["nsenter", f"--net=/proc/{pid}/ns/net", *map(str, words), "--ssp", hexapod_ssp]
        second.append(subprocess.run(inside, capture_output=True, text=True))

    ran = Bench(hexapod_ssp, tmp_path).run(during=when_running(start), seconds=20.0)
    assert second[0].returncode == 1
    assert "another flexhex-gateway" in second[0].stdout
    assert ran.code == 0, ran.words
    assert ran.one("summary")["lost"] == 0


def test_port_that_is_down_and_missing_rights_are_reported(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    down = ("ip", "link", "set", "bus1", "down")
    switched_off = ("sh", "-c", f'{" ".join(down)}; exec "$@"', "sh")
    ran = Bench(hexapod_ssp, tmp_path).run(wrapper=switched_off, command=RUN)
    assert ran.code == 1
    assert "is down: `ip link set bus1 up`" in ran.one("refused")["message"]
    nobody = ("setpriv", "--bounding-set=-all", "--inh-caps=-all", "--no-new-privs")
    ran = Bench(hexapod_ssp, tmp_path).run(wrapper=nobody, command=RUN)
    assert ran.code == 1
    assert "setcap cap_net_raw" in ran.one("refused")["message"]

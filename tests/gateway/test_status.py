"""A run as others see it: `status` from another shell, and over HTTP."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tests.gateway.bench import Bench
from tests.gateway.cargo import built
from tests.gateway.test_readback import SHORT
from tests.gateway.test_refusals import when_running

PORT = 4850
FETCH = """
import http.client, json, sys
def ask(method, path, host="127.0.0.1:{port}"):
    connection = http.client.HTTPConnection("127.0.0.1", {port}, timeout=5)
    connection.putrequest(method, path, skip_host=True)
    connection.putheader("Host", host)
    connection.endheaders()
    answer = connection.getresponse()
    return [answer.status, answer.read().decode(), dict(answer.getheaders())]
print(json.dumps([ask("GET", "/"), ask("GET", "/status.json"), ask("POST", "/status.json"),
                  ask("GET", "/status.json", "evil.example"), ask("GET", "/a")]))
"""


def beside(gateway: subprocess.Popen[str], *words: object) -> subprocess.CompletedProcess[str]:
    """A command in the network of a running gateway."""
    command = ["nsenter", "--net", "--target", str(gateway.pid), *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60)


def queried(
    bench: Bench, state: dict[str, Any], *options: object
) -> Callable[[subprocess.Popen[str]], None]:
    """Asks a running gateway for its status, and ends it."""
    program = built() / "flexhex-gateway"
    words = (program, "status", bench.folder / "machine.toml", "--interface", "bus1", *options)

    def ask(gateway: subprocess.Popen[str]) -> None:
        def act(pid: int) -> None:
            state["status"] = beside(gateway, *words)
            state["page"] = beside(gateway, "python3", "-c", FETCH.format(port=PORT))
            os.kill(pid, signal.SIGINT)

        beside(gateway, "ip", "link", "set", "lo", "up")
        when_running(act)(gateway)

    return ask


UP = ("sh", "-c", 'ip link set lo up; exec "$@"', "sh")
"""A new network has no 127.0.0.1 until its loopback is up."""


def test_status_and_page_show_a_run_and_only_read(hexapod_ssp: Path, tmp_path: Path) -> None:
    state: dict[str, Any] = {}
    bench = Bench(hexapod_ssp, tmp_path)
    ran = bench.run(
        seconds=1000.0,
        command=("run", "--enable", "--lockstep", "--page", PORT),
        wrapper=UP,
        during=queried(bench, state, "--json"),
    )
    assert ran.code == 0, ran.words
    assert f"http://127.0.0.1:{PORT}/" in ran.words
    done = state["status"]
    assert done.returncode == 0, done.stderr
    live = json.loads(done.stdout.splitlines()[-1])
    assert (live["event"], live["phase"]) == ("live", "running")
    # what is shown is one row of the recording, whole
    row = int(np.flatnonzero(ran.table["cycle"] == live["cycle"])[0])
    for name in ("theta", "r", "e", "tau", "tau_meas", "tau_ff", "statusword", "al_state"):
        assert list(ran.table[name][row]) == live[name], name
    assert live["state"] == ["operation enabled"] * 6
    assert live["about"]["torque_N_m"] == [27.0] * 6
    axes = [line.split() for line in done.stderr.splitlines() if "operation enabled" in line]
    assert [line[0] for line in axes] == list("123456")
    assert float(axes[2][1]) == round(live["theta"][2], 6)
    page, shown, posted, foreign, unknown = json.loads(state["page"].stdout)
    assert page[0] == 200
    assert "<!doctype html>" in page[1]
    assert "default-src 'none'" in page[2]["Content-Security-Policy"]
    assert shown[0] == 200
    assert json.loads(shown[1])["cycle"] > live["cycle"], "it goes on"
    assert (posted[0], foreign[0], unknown[0]) == (405, 403, 404)


def test_status_without_a_gateway_is_refused(hexapod_ssp: Path, tmp_path: Path) -> None:
    ran = Bench(hexapod_ssp, tmp_path).run(command=("status",))
    assert ran.code == 1
    assert 'no flexhex-gateway runs on "bus1"' in ran.one("refused")["message"]


TAKEN = (
    "import os, socket, sys; taken = socket.create_server(('127.0.0.1', int(sys.argv[1])));"
    "taken.set_inheritable(True); os.execvp(sys.argv[2], sys.argv[2:])"
)


def test_page_that_cannot_be_served_is_refused_before_power(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    """Another program has the port."""
    command = ("run", "--enable", "--lockstep", "--page", PORT)
    wrapper = (sys.executable, "-c", TAKEN, PORT)
    ran = Bench(hexapod_ssp, tmp_path).run(command=command, seconds=SHORT, wrapper=wrapper)
    assert ran.code == 1
    assert f"--page {PORT}: Address already in use" in ran.one("refused")["message"]
    assert not ran.happened("state"), "not one frame was sent"

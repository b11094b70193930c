"""`flexhex view --live`: a recording that still grows, as the gateway writes it."""

from __future__ import annotations

import http.client
import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import typer
from numpy.typing import NDArray
from typer.testing import CliRunner

from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.fmus.common.machine_file import load_machine
from flexhex.view.command import view_command
from flexhex.view.live import SECONDS, STILL, Live, server, wait_for_rows
from flexhex.view.tail import Tail
from tests.conftest import MACHINE_FILE
from tests.flexhex.browser import Browser
from tests.flexhex.test_compare import BASE
from tests.flexhex.test_view import numbers, run_of

RUN = run_of(seconds=30.0)
MACHINE = load_machine(MACHINE_FILE)
NAMES = ("theta", "e", "tau_meas")
SIGNALS = ("plant.theta", "feedback.e", "plant.tau_meas")
ENABLING = 400
"""Cycles before the controller runs."""


def head() -> str:
    signals = " ".join(
        f"{n}={s}:{2 if n == 'e' else 1}" for n, s in zip(NAMES, SIGNALS, strict=True)
    )
    names = ["time", *(f"{n}[{i}]" for n in NAMES for i in range(1, 7)), "phase"]
    units = ["s", *["rad"] * 12, *["N m"] * 6, "1"]
    meta = f"# base_step_s: {BASE}\n# signals: {signals}\n"
    return meta + ",".join(names) + "\n" + ",".join(units) + "\n"


def rows(first: int, end: int) -> str:
    """Cycles first to end of the run; it begins after those in which the drives are enabled."""
    text = ""
    for n in range(first, end):
        k = max(0, n - ENABLING)
        values = np.concatenate([RUN[signal][k] for signal in SIGNALS])
        cells = ",".join(f"{value:.9g}" for value in values)
        text += f"{n * BASE:.9g},{cells},{1 if n >= ENABLING else 0}\n"
    return text


@pytest.fixture
def growing(tmp_path: Path) -> Path:
    """A recording of which the drives are still enabled."""
    path = tmp_path / "run.csv"
    path.write_text(head() + rows(0, ENABLING))
    return path


def add(path: Path, text: str) -> None:
    with path.open("a") as file:
        file.write(text)


@contextmanager
def served(live: Live) -> Iterator[int]:
    """The page on a port of its own."""
    with server(live, 0) as serving:
        thread = threading.Thread(target=serving.serve_forever, daemon=True)
        thread.start()
        yield serving.server_port
        serving.shutdown()
        thread.join()


def theta_of(data: dict[str, object]) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    frames = data["runs"][0]["frames"]  # type: ignore[index]
    times = frames["t0"] + frames["step"] * np.arange(frames["count"])
    return times, numbers(frames["theta"]).reshape(-1, 6)


def test_newest_rows_are_shown_on_the_clock_of_the_run(growing: Path) -> None:
    live = Live(growing, MACHINE)
    assert live.newest()["data"] == {}, "the controller does not run yet"
    text = rows(ENABLING, ENABLING + 2000)
    add(growing, text[:-30])
    first = live.newest()
    add(growing, text[-30:])
    second = live.newest()
    assert (first["count"], second["count"]) == (1999, 2000), "half a row waits"
    times, theta = theta_of(second["data"])
    assert times[0] == pytest.approx(ENABLING * BASE)
    places = np.rint(times / BASE).astype(int) - ENABLING
    assert np.allclose(theta, RUN["plant.theta"][places], atol=1e-8)
    assert second["data"]["end"] == pytest.approx((ENABLING + 1999) * BASE)
    error = next(s for s in second["data"]["runs"][0]["signals"] if s["name"] == "feedback.e")
    assert error["Ts"] == 2 * BASE
    assert second["said"] == ""


def test_only_the_last_seconds_are_kept(growing: Path) -> None:
    tail = Tail(growing, 0.1)
    add(growing, rows(ENABLING, ENABLING + 3000))
    tail.read()
    actual = tail.result()
    assert actual is not None
    result, begin = actual
    assert begin == pytest.approx((ENABLING + 3000 - 1) * BASE - 0.1, abs=2 * BASE)
    assert result.duration == pytest.approx(0.1, abs=2 * BASE)
    assert SECONDS >= 10


def test_trip_and_standstill_are_said(growing: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    live = Live(growing, MACHINE)
    add(growing, rows(ENABLING, ENABLING + 100))
    assert live.newest()["said"] == ""
    now = time.monotonic()
    monkeypatch.setattr("flexhex.view.live.time.monotonic", lambda: now + STILL + 2)
    assert live.newest()["said"].startswith("no new row for ")
    add(growing, "# trip: following error of joint 2\n")
    assert live.newest()["said"] == "trip: following error of joint 2"


def test_what_is_no_recording_is_refused(tmp_path: Path, growing: Path) -> None:
    for text in (
        "",
        "time,theta\ns,rad\n0,1\n",
        head()[:60],
        "# base_step_s: x\n# signals: a\na\nb\n",
    ):
        path = tmp_path / "no.csv"
        path.write_text(text)
        with pytest.raises(LogError, match="no recording of the gateway"):
            Live(path, MACHINE)
    with pytest.raises(LogError, match="no such file"):
        Live(tmp_path / "none.csv", MACHINE)
    live = Live(growing, MACHINE)
    add(growing, "1,2,3\n")
    with pytest.raises(LogError, match="damaged"):
        live.newest()


def test_server_answers_this_computer_alone(growing: Path) -> None:
    add(growing, rows(ENABLING, ENABLING + 100))
    live = Live(growing, MACHINE)
    with served(live) as port:

        def response(path: str, host: str) -> tuple[int, str]:
            connection = http.client.HTTPConnection("127.0.0.1", port)
            connection.request("GET", path, headers={"Host": host})
            answer = connection.getresponse()
            return answer.status, answer.read().decode()

        ours = f"127.0.0.1:{port}"
        assert response("/", ours)[0] == 200
        assert json.loads(response("/run.json", ours)[1])["data"]["runs"]
        assert json.loads(response("/run.json?have=100", ours)[1])["data"] == {}
        assert response("/etc/passwd", ours)[0] == 404
        assert response("/run.json", f"evil.example:{port}")[0] == 403
        with pytest.raises(UsageError, match="give another port"):
            server(live, port)


def test_live_follows_one_recording(tmp_path: Path) -> None:
    app = typer.Typer()
    app.command("view")(view_command)
    app.callback()(lambda: None)
    done = CliRunner().invoke(app, ["view", "--live", "a.csv", "b.csv"])
    assert isinstance(done.exception, UsageError)


def test_page_follows_the_run(browser: Browser, growing: Path) -> None:
    """New rows move the machine and the plots; a standstill is said; the slider stops following."""
    add(growing, rows(ENABLING, 4000))
    live = Live(growing, MACHINE)
    wait_for_rows(live)
    over = threading.Event()

    def write() -> None:
        for first in range(4000, 40_000, 400):
            add(growing, rows(first, first + 400))
            if over.wait(0.1):
                return

    with served(live) as port:
        writer = threading.Thread(target=write)
        browser.requests.clear()
        browser.open(f"http://127.0.0.1:{port}/")
        writer.start()
        try:
            seen = []
            for _ in range(3):
                browser.run("new Promise(done => setTimeout(done, 700))")
                state = "[state.t, DATA.end, byId('state').textContent]"
                seen.append((*browser.run(state), browser.pixels()))
        finally:
            over.set()
            writer.join()
        (t0, end0, said, before), _, (t1, end1, _, after) = seen
        assert said == "live"
        assert end1 > end0 >= t0
        assert t1 > t0 + 0.3
        assert end1 - t1 < 1.5
        assert (np.abs(before - after).max(axis=2) > 40).mean() > 0.01
        browser.run(
            "byId('time').value = DATA.begin; byId('time').dispatchEvent(new Event('input'))"
        )
        browser.run("new Promise(done => setTimeout(done, 600))")
        assert browser.run("state.playing") is False
        assert browser.run("state.t") == pytest.approx(browser.run("DATA.begin"), abs=0.01)
        requests = [url for url in browser.requests if not url.startswith(("blob:", "data:"))]
        strangers = {url.partition("?")[0] for url in requests}
        home = f"http://127.0.0.1:{port}"
        assert strangers <= {f"{home}/", f"{home}/run.json", f"{home}/favicon.ico"}
    browser.run("new Promise(done => setTimeout(done, 600))")
    assert "ended" in browser.run("byId('state').textContent")
    # the browser itself notes a missing icon and that nobody answers any more
    assert all("ERR_" in said or "404" in said for said in browser.said), browser.said
    browser.open("about:blank", wait=False)
    browser.said.clear()

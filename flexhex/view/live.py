"""A recording that runs, as a page on 127.0.0.1 whose newest seconds follow the file."""

from __future__ import annotations

import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from flexhex.compare.runs import named_runs
from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.view.data import Size, page_data
from flexhex.view.page import json_text, view_html
from flexhex.view.tail import Tail

SECONDS = 20.0
"""What the page shows [s]."""
SIZE = Size(frames=1200, values=80_000)
STILL = 3.0
"""Time without a new row after which the page says so [s]."""
PERIOD = 0.25
"""Between two looks for a first row [s]."""


class Live:
    """A file and its newest data as JSON. Its methods may be called from several threads."""

    def __init__(self, path: Path, machine: Machine) -> None:
        """LogError for a file that is no recording."""
        self.path, self.machine = path, machine
        self._tail = Tail(path, SECONDS)
        self._lock = threading.Lock()
        self._count, self._data = 0, dict[str, Any]()
        self._grew = time.monotonic()

    def newest(self) -> dict[str, Any]:
        """`count` rows so far, `said` of them, `data` as `page_data`; empty before the first rows.

        LogError for damaged rows, UsageError for a machine that cannot be shown.
        """
        with self._lock:
            self._tail.read()
            if self._tail.count > self._count and (tail := self._tail.result()):
                self._count, self._grew = self._tail.count, time.monotonic()
                result, begin = tail
                runs = named_runs([self.path], [result])
                data = page_data(runs, self.machine, (0.0, float("inf")), SIZE)
                self._data = _shifted({**data, "settled": data["begin"]}, begin)
            still = time.monotonic() - self._grew
            said = f"trip: {self._tail.trip}" if self._tail.trip else ""
            if not said and still > STILL:
                said = f"no new row for {still:.0f} s"
            return {"count": self._count, "said": said, "data": self._data}


def _shifted(data: dict[str, Any], by: float) -> dict[str, Any]:
    """The same with all times later by `by` [s]: on the clock of the run."""
    for key in ("begin", "end", "settled"):
        data[key] += by
    for run in data["runs"]:
        run["frames"]["t0"] += by
        for signal in run["signals"]:
            for line in signal["lines"]:
                line["t0"] += by
    return data


def wait_for_rows(live: Live) -> None:
    """Return when there is something to show."""
    while not live.newest()["data"]:
        time.sleep(PERIOD)


def server(live: Live, port: int) -> ThreadingHTTPServer:
    """Serves the page at / and its data at /run.json, to this computer alone.

    port: 0 for any free one. UsageError where the port is taken.
    """

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            # a page of another site that calls itself 127.0.0.1 by its name server is no reader
            host = self.headers.get("Host", "").rpartition(":")[0]
            path, _, have = self.path.partition("?have=")
            if host not in ("127.0.0.1", "localhost"):
                self._answer(403, "text/plain", "only for this computer\n")
            elif path == "/":
                text = view_html(live.path.name, live.newest()["data"], live=True)
                self._answer(200, "text/html", text)
            elif path == "/run.json":
                self._answer(200, "application/json", _newest(live, have))
            else:
                self._answer(404, "text/plain", "there are / and /run.json\n")

        def _answer(self, status: int, kind: str, text: str) -> None:
            body = text.encode()
            self.send_response(status)
            self.send_header("Content-Type", f"{kind}; charset=utf-8")
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: Any) -> None:
            """Requests are not printed."""

    try:
        return ThreadingHTTPServer(("127.0.0.1", port), Handler)
    except OSError as error:
        raise UsageError(f"--port {port}: {error.strerror or error}: give another port") from None


def _newest(live: Live, have: str) -> str:
    """The newest data, without those that the page has."""
    try:
        newest = live.newest()
    except LogError as error:
        newest = {"count": 0, "said": str(error), "data": {}}
    if str(newest["count"]) == have:
        newest = {**newest, "data": {}}
    return json_text(newest)

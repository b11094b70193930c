"""Chromium without a window, driven through its debugging pipe: pages, keys, mouse, pictures."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import struct
import subprocess
import time
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--disable-extensions", "--no-first-run",
    "--disable-background-networking",
)  # fmt: skip
PATIENCE = 60.0
"""Time after which a browser that does not answer is taken for broken [s]."""


class Browser:
    """One page. `said` collects errors, warnings and exceptions of the console; `asked` every
    address that the page asked for."""

    def __init__(self, profile: Path) -> None:
        program = next((found for name in NAMES if (found := shutil.which(name))), None)
        if program is None:
            pytest.skip("no Chromium on the PATH")
        to_us, theirs = os.pipe()
        ours, to_them = os.pipe()
        self._in, self._out, self._count, self._rest = to_us, to_them, 0, b""
        self.said: list[str] = []
        self.asked: list[str] = []
        command = [program, *FLAGS, f"--user-data-dir={profile}", "about:blank"]
        # the browser reads from its file 3 and writes to its file 4
        wired = f'exec 3<&{ours} 4>&{theirs}; exec "$@"'
        self._process = subprocess.Popen(
            ["bash", "-c", wired, "bash", *command],
            pass_fds=(ours, theirs),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(ours)
        os.close(theirs)
        self._session = ""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """One command and its answer; events that come meanwhile are noted."""
        self._count += 1
        message: dict[str, Any] = {"id": self._count, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._read()
            if answer.get("id") == self._count:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                result: dict[str, Any] = answer["result"]
                return result
            self._note(answer)

    def _read(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            if not select.select([self._in], [], [], PATIENCE)[0]:
                raise TimeoutError("the browser does not answer")
            part = os.read(self._in, 1 << 20)
            if not part:
                raise EOFError("the browser ended")
            self._rest += part
        text, _, self._rest = self._rest.partition(b"\0")
        message: dict[str, Any] = json.loads(text)
        return message

    def _note(self, event: dict[str, Any]) -> None:
        method, params = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            self.said.append(json.dumps(params["exceptionDetails"]))
        elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning"):
            self.said.append(json.dumps(params["args"]))
        elif method == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
            self.said.append(params["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.asked.append(params["request"]["url"])

    def open(self, page: Path, width: int = 1440, height: int = 900, dark: bool = False) -> None:
        """Show a page and wait until it says that it is ready."""
        scheme = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        self.call("Emulation.setEmulatedMedia", features=scheme)
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width, height=height, deviceScaleFactor=1, mobile=width < 600,
        )  # fmt: skip
        self.call("Page.navigate", url=page.absolute().as_uri())
        end = time.monotonic() + PATIENCE
        while self.run("document.documentElement?.dataset.ready") != "yes":
            if time.monotonic() > end:
                raise TimeoutError(f"the page is not ready: {self.said}")
            time.sleep(0.05)

    def run(self, script: str) -> Any:
        """Value of an expression in the page."""
        found = self.call(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in found:
            raise RuntimeError(json.dumps(found["exceptionDetails"]))
        return found["result"].get("value")

    def drawn(self) -> None:
        """Wait until what was changed is on the screen."""
        self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def press(self, key: str, code: int = 0, text: str = "") -> None:
        """A key of the keyboard."""
        what = {"key": key, "windowsVirtualKeyCode": code, "text": text}
        self.call("Input.dispatchKeyEvent", type="keyDown", **what)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, windowsVirtualKeyCode=code)
        self.drawn()

    def mouse(self, kind: str, x: float, y: float, button: str = "none") -> None:
        """`mouseMoved`, `mousePressed`, `mouseReleased` at a place of the window."""
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, clickCount=1)
        self.drawn()

    def picture(self) -> bytes:
        """What the window shows, as PNG."""
        self.drawn()
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])

    def close(self) -> None:
        """End the browser."""
        try:
            self._session = ""
            self.call("Browser.close")
        except (OSError, EOFError, TimeoutError):
            self._process.kill()
        self._process.wait(PATIENCE)
        os.close(self._in)
        os.close(self._out)


def pixels(png: bytes) -> NDArray[np.int16]:
    """Pixels (height, width, channels) of a PNG of 8 bits without interlace."""
    at, data, head = 8, b"", b""
    while at < len(png):
        size, kind = struct.unpack(">I4s", png[at : at + 8])
        body = png[at + 8 : at + 8 + size]
        head, data = (body if kind == b"IHDR" else head), data + (body if kind == b"IDAT" else b"")
        at += 12 + size
    width, height, depth, colour = struct.unpack(">IIBB", head[:10])
    channels = {2: 3, 6: 4}[colour]
    assert depth == 8
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, 1 + width * channels)
    image = np.zeros((height, width, channels), np.int16)
    above = np.zeros((width, channels), np.int16)
    for k, row in enumerate(rows):
        image[k] = above = _unfiltered(int(row[0]), row[1:].reshape(width, channels), above)
    return image


def _unfiltered(kind: int, row: NDArray[np.uint8], above: NDArray[np.int16]) -> NDArray[np.int16]:
    line = row.astype(np.int16)
    if kind == 0:
        return line
    if kind == 2:
        return np.asarray((line + above) & 0xFF)
    if kind == 1:
        return np.asarray(np.cumsum(line, axis=0) & 0xFF, dtype=np.int16)
    left = corner = np.zeros(line.shape[1], np.int16)
    for k in range(len(line)):
        up = above[k]
        if kind == 3:
            guess = (left + up) // 2
        else:
            p = left + up - corner
            far = np.abs(np.stack([p - left, p - up, p - corner]))
            guess = np.choose(far.argmin(axis=0), [left, up, corner])
        left = line[k] = (line[k] + guess) & 0xFF
        corner = up
    return line

"""Chromium without a window, driven through its debugging pipe: pages, keys, mouse, pictures."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import time
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
UNPACK = """(async () => {
  const image = new Image();
  image.src = %s;
  await image.decode();
  const canvas = new OffscreenCanvas(image.width, image.height), context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  const data = context.getImageData(0, 0, image.width, image.height).data;
  let text = "";
  for (let k = 0; k < data.length; k += 32768) {
    text += String.fromCharCode(...data.subarray(k, k + 32768));
  }
  return [image.width, image.height, btoa(text)];
})()"""
PATIENCE = 300.0
"""Time after which a browser that does not answer is taken for broken [s]; a busy computer with
neither GPU nor free core took more than 60."""


class Browser:
    """One page. `said` collects errors, warnings and exceptions of the console; `asked` every
    address that the page asked for."""

    def __init__(self, profile: Path) -> None:
        program = next((path for name in NAMES if (path := shutil.which(name))), None)
        if program is None:
            pytest.skip("no Chromium on the PATH")
        to_us, theirs = os.pipe()
        ours, to_them = os.pipe()
        self._in, self._out, self._count, self._rest = to_us, to_them, 0, b""
        self.said: list[str] = []
        self.requests: list[str] = []
        self._loaded = False
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
            self.requests.append(params["request"]["url"])
        elif method == "Page.loadEventFired":
            self._loaded = True

    def open(
        self,
        page: Path | str,
        width: int = 1440,
        height: int = 900,
        dark: bool = False,
        wait: bool = True,
    ) -> None:
        """Show a page, a file or an address, and wait until it says that it is ready.

        wait: False for a page that never says so.
        """
        scheme = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        self.call("Emulation.setEmulatedMedia", features=scheme)
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width, height=height, deviceScaleFactor=1, mobile=width < 600,
        )  # fmt: skip
        address = page if isinstance(page, str) else page.absolute().as_uri()
        self._loaded = False
        self.call("Page.navigate", url=address)
        # a script that is asked while one page gives way to another may never be answered
        while not self._loaded:
            self._note(self._read())
        end = time.monotonic() + PATIENCE
        while wait and self.run("document.documentElement?.dataset.ready") != "yes":
            if time.monotonic() > end:
                raise TimeoutError(f"the page is not ready: {self.said}")
            time.sleep(0.05)

    def run(self, script: str) -> Any:
        """Value of an expression in the page."""
        response = self.call(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in response:
            raise RuntimeError(json.dumps(response["exceptionDetails"]))
        return response["result"].get("value")

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

    def pixels(self) -> NDArray[np.int16]:
        """What the window shows: (height, width, 3), 0 to 255; the browser unpacks its own PNG."""
        return self.unpacked(self.picture())

    def unpacked(self, picture: bytes) -> NDArray[np.int16]:
        """The pixels of a PNG; the page must allow images of its own."""
        source = f"data:image/png;base64,{base64.b64encode(picture).decode()}"
        width, height, text = self.run(UNPACK % json.dumps(source))
        image = np.frombuffer(base64.b64decode(text), np.uint8).reshape(height, width, 4)
        return image[..., :3].astype(np.int16)

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

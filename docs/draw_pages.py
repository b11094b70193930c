"""Draws the pictures of pages in headless Chromium: hexapod.png, my-hexapod.png, arm.png,
diagnosis.png.

python -m docs.draw_pages out/runs/feedback.h5 out/runs/adaptive.h5
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from flexhex.diagnosis.prepare import Options
from flexhex.fmus.common.machine_file import load_machine
from flexhex.view.data import page_data
from flexhex.view.measured import measured_runs
from flexhex.view.page import write_view
from flexhex.view.sources import load_sources
from tests.flexhex.browser import Browser

HERE = Path(__file__).resolve().parent
SPAN, SHOWN, FACTOR = (3.25, 7.0), 5.47, 1000.0
"""Time of the plots and of the bodies [s], where feedback only is far off; magnification."""
INIT = ("--radius", "0.12", "--upper", "0.2", "--height", "0.25")
"""The hexapod of my-hexapod.md."""
ARM, MOVING = ("run_001", "run_040", "run_060", "run_080"), 2.0
"""Logs of examples/schunk, and the time of the first that is shown [s]."""
REST = 3.0
"""Time after which what rests is drawn finely [s]."""


def picture(page: Path, name: str, width: int, height: int) -> None:
    """The top of a page as a file beside this one."""
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser(Path(profile))
        browser.call("Emulation.setScrollbarsHidden", hidden=True)
        browser.open(page, width, height)
        time.sleep(REST)
        (HERE / name).write_bytes(browser.picture())
        browser.close()


def flexhex(folder: Path, *words: str, code: int = 0) -> None:
    """A command in a folder; its exit code must be that."""
    done = subprocess.run([sys.executable, "-m", "flexhex", *words], cwd=folder)
    if done.returncode != code:
        raise SystemExit(f"flexhex {' '.join(words)}: exit code {done.returncode}")


def main(files: list[Path]) -> None:
    """Make the pages in a folder that vanishes, and their pictures."""
    machine = load_machine(HERE.parent / "machines" / "tflex.toml")
    data = page_data(load_sources(files), machine, SPAN, ghost="beside", factor=FACTOR, t=SHOWN)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        page = write_view(folder / "page.html", "flexhex view", data)
        picture(page, "hexapod.png", 1120, 600)
        flexhex(folder, "init", "my.toml", *INIT)
        picture(folder / "my.html", "my-hexapod.png", 1100, 620)
        logs = [HERE.parent / "examples" / "schunk" / f"{log}.csv" for log in ARM]
        runs, shape, _ = measured_runs(logs, None, Options(str(logs[0].with_name("lwa4p.toml"))))
        page = write_view(page, "arm", page_data(runs, shape, (0.0, 60.0), t=MOVING))
        picture(page, "arm.png", 1120, 640)
        (folder / "axis").symlink_to(HERE.parent / "examples" / "axis")
        named = [f"axis/{log}.csv" for log in ("a1", "a2", "b1", "b2")]
        held_out = ("--held-out", "axis/c1.csv")
        flexhex(folder, "diagnose", *named, "--base", "axis", *held_out, code=1)
        picture(folder / "out" / "diagnose" / "diagnosis.html", "diagnosis.png", 1000, 1000)


if __name__ == "__main__":
    main([Path(word) for word in sys.argv[1:]])

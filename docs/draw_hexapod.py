"""Draws docs/hexapod.png: feedback only beside adaptive feedforward, in headless Chromium.

python docs/draw_hexapod.py out/runs/feedback.h5 out/runs/adaptive.h5
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from flexhex.fmus.common.machine_file import load_machine
from flexhex.view.data import page_data
from flexhex.view.page import write_view
from flexhex.view.sources import load_sources

HERE = Path(__file__).resolve().parent
SPAN, FACTOR = (3.25, 7.0), 32.0
"""Time that is shown [s], begun in a move; magnification of the error."""
WINDOW = "1200,640"
CHROMIUM = (
    "chromium", "--headless=new", "--no-sandbox", "--hide-scrollbars", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--virtual-time-budget=20000", f"--window-size={WINDOW}",
)  # fmt: skip


def main(files: list[Path], target: Path) -> None:
    """Write the page of both runs and take its picture."""
    machine = load_machine(HERE.parent / "machines" / "tflex.toml")
    data = page_data(load_sources(files), machine, SPAN, ghost="beside", factor=FACTOR)
    with tempfile.TemporaryDirectory() as folder:
        page = write_view(Path(folder) / "page.html", "flexhex view", data)
        subprocess.run([*CHROMIUM, f"--screenshot={target}", page.as_uri()], check=True)


if __name__ == "__main__":
    main([Path(word) for word in sys.argv[1:]], HERE / "hexapod.png")

"""The progress of a command, as stderr can show it."""

from __future__ import annotations

import sys

from flexhex.output.bars import Bars
from flexhex.output.lines import Lines
from flexhex.output.progress import Progress


def live() -> Progress:
    """Bars in a terminal, lines elsewhere."""
    return Bars() if sys.stderr.isatty() else Lines(sys.stderr)

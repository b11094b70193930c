"""A machine file whose values are wrong by many of its tolerances."""

from __future__ import annotations

from pathlib import Path

from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.prepare import Options
from flexhex.init import two_links as example
from tests.diagnosis.estimation.test_identified import TRUE, arm, covered


def test_file_that_is_far_off_is_left_behind(tmp_path: Path) -> None:
    """The second link weighs half, says the file, and is sure of it: 200 and 150 tolerances off."""
    text = Path(example.__file__).read_text()
    wrong = {'"kg", 2.0, 0.1)': '"kg", 1.0, 0.005)', '"kg m", 0.30, 0.015)': '"kg m", 0.15, 0.001)'}
    for right, value in wrong.items():
        assert right in text
        text = text.replace(right, value)
    (tmp_path / "base.py").write_text(text)
    paths = arm(tmp_path, (1, 2, 3))
    options = Options(f"{tmp_path / 'base.py'}:TwoLinks")
    identified = identify(paths[:2], paths[2:], options=options)
    assert identified.held_out is not None
    assert (identified.held_out.file > 0.2).all()
    assert (identified.held_out.fitted < 0.01).all()
    assert covered(identified, "link_2.mc", TRUE["link_2.mc"])

"""The figure of docs/method.md shows what was accepted, and with what beside it."""

from __future__ import annotations

from xml.etree import ElementTree

from flexhex.diagnosis.result.pictured import Candidate
from studies.method_figure import LEFT, picture


def test_bars_are_as_long_as_the_gains() -> None:
    listed = [
        Candidate(1, "quadratic_drag", (4,), {}, 200.0, 0.02, chosen=True),
        Candidate(1, "coulomb_friction", (4,), {}, 100.0, 0.01, rival=True),
        Candidate(2, "end_effector.m", (), {}, 4.0, 0.001),
    ]
    root = ElementTree.fromstring(picture(listed))
    name = "{http://www.w3.org/2000/svg}"
    bars = [r for r in root.findall(f"{name}rect") if r.get("x") == str(LEFT)]
    first, second, third = (float(str(r.get("width"))) for r in bars)
    assert first == 2 * second == third, "each round has its own scale"
    assert [r.get("fill") for r in bars] == ["#1f4e8c", "url(#like)", "#d0d4da"]
    said = [str(t.text) for t in root.findall(f"{name}text")]
    assert "coulomb_friction, axis 4" in said
    assert "100 nats, 1.00 %" in said

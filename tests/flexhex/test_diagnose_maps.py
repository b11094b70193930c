"""Figures of where the residual is: an axis at a time, gaps where no data are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexhex.diagnose.maps import map_figures, spectrum_figures
from flexhex.diagnosis.result.pictured import Map
from flexhex.output.plots import broken

BINS = np.array([0.0, 1.0, 2.0, 5.0, 6.0])
TURNS = Map(2, "angle", "rad", BINS, BINS + 1.0, 0.1 * BINS, np.full(5, 0.25))
SLIDES = replace(TURNS, axis=1, over="position", unit="m", residual="N")
SPECTRUM = replace(TURNS, over="frequency", unit="Hz")


def test_no_line_bridges_missing_samples() -> None:
    x, y = broken(BINS, 2 * BINS)
    assert x.tolist() == [0.0, 1.0, 2.0, 3.5, 5.0, 6.0]
    assert np.isnan(y).tolist() == [False, False, False, True, False, False]
    for short in (BINS[:0], BINS[:1], BINS[:2]):
        assert [part.tolist() for part in broken(short, short)] == [short.tolist()] * 2


def test_axes_of_one_kind_share_a_figure_and_others_have_their_own() -> None:
    third = replace(TURNS, axis=3)
    drawn = map_figures([TURNS, SLIDES, third, SPECTRUM], first=3)
    titles = [f["layout"]["xaxis"]["title"]["text"] for f in drawn.values()]
    assert titles == ["angle [rad]", "position [m]"]
    angle, position = drawn.values()
    assert [line["meta"]["joint"] for line in angle["data"]] == [2, 2, 2, 3, 3, 3]
    assert [line["meta"]["joint"] for line in position["data"]] == [1, 1, 1]
    assert angle["layout"]["meta"] == {"joint": "axis", "first": 3}
    (spectrum,) = spectrum_figures([TURNS, SPECTRUM], first=2).values()
    assert [line["name"] for line in spectrum["data"]] == ["before", "after"]


def test_labels_of_a_spectrum_have_room() -> None:
    def dtick(before: float) -> object:
        one = replace(SPECTRUM, before=np.full(5, before), after=np.full(5, 1e-4))
        (drawn,) = spectrum_figures([one], first=2).values()
        return drawn["layout"]["yaxis"]["dtick"]

    assert [dtick(4e-4), dtick(1e-2)] == ["D2", 1]


def test_lines_and_band_have_a_gap_where_bins_are_missing() -> None:
    (drawn,) = map_figures([TURNS], first=2).values()
    band, before, after = drawn["data"]
    assert before["y"] == [1.0, 2.0, 3.0, None, 6.0, 7.0]
    assert after["y"][3] is None
    assert band["x"] == [0.0, 1.0, 2.0, 2.0, 1.0, 0.0, None, 5.0, 6.0, 6.0, 5.0, None]
    assert band["y"] == [0.5, 1.5, 2.5, 3.5, 2.5, 1.5, None, 5.5, 6.5, 7.5, 6.5, None]
    assert band["meta"] == {"joins": True, "joint": 2}, "no line of the data that are downloaded"

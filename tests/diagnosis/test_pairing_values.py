"""Which base models are asked whether logs are theirs: all that know values, exact ones too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexhex.diagnosis.basemodels.bases import base_of
from flexhex.diagnosis.logs import Log
from flexhex.diagnosis.runs.pairing import mispaired
from tests.diagnosis.test_pairing import base, runs, same
from tests.diagnosis.two_links import TS


def test_values_that_are_exact_tell_a_wrong_arrangement_too() -> None:
    exact = base()
    exact.linear = tuple(replace(known, tolerance=0.0) for known in exact.linear)
    assert "all torques negated" in mispaired(exact, runs(same, lambda v: -v))
    assert mispaired(exact, runs(same, same)) == ""


def test_base_model_without_values_says_nothing() -> None:
    empty = base_of("axis", None, Log.of("run.csv", TS, *np.ones((2, 10, 2))))
    assert mispaired(empty, runs(same, lambda v: -v)) == ""

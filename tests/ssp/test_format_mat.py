"""MAT files: what MATLAB sees, and that a damaged one is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from flexhex.fmus.common.errors import LogError
from flexhex.ssp.formats.mat import identifiers
from flexhex.ssp.result import Result
from flexhex.ssp.results import load, save
from tests.ssp.test_formats import result

__all__ = ["result"]


def test_mat_holds_a_struct_for_each_rate(result: Result, tmp_path: Path) -> None:
    loaded = loadmat(str(save(result, tmp_path / "ü.mat")), simplify_cells=True)
    slow, fast = loaded["rate_250ms"], loaded["rate_0_25ms"]
    assert np.array_equal(fast["feedback_e"], result["feedback.e"], equal_nan=True)
    assert np.array_equal(fast["time"], result.time("feedback.e"))
    assert np.array_equal(slow["K_p_std_lower_J_xx"], result["K.p_std.lower.J_xx"])
    assert (fast["unit"]["plant_tau_meas"], fast["unit"]["time"]) == ("N m", "s")
    assert slow["unit"]["K_p"].tolist() == ["N m", "kg m2"]
    assert slow["name"]["K_p"].tolist() == ["K.p.actuator[1].o", "K.p.lower.J_xx"]
    assert slow["name"]["K_p_std_lower_J_xx"] == "K.p_std.lower.J_xx"
    assert (loaded["meta"]["case"], loaded["meta"]["n"]) == ("fixed", 3)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('"version": 1', '"version": 9', "version 9 of the format, this program reads 1"),
        ('"shape": [6, 2]', '"shape": [7, 2]', "damaged result"),
        ('"K.p"', '"K.q"', "damaged result"),
        ('"duration_s"', '"length"', "damaged result"),
    ],
)
def test_broken_mat_is_refused(
    result: Result, tmp_path: Path, old: str, new: str, reason: str
) -> None:
    path = save(result, tmp_path / "r.mat")
    content = {k: v for k, v in loadmat(str(path)).items() if not k.startswith("__")}
    text = str(content["flexhex_result"][0])
    assert old in text
    savemat(path, content | {"flexhex_result": text.replace(old, new)})
    with pytest.raises(LogError, match=f"r.mat: .*{reason}"):
        load(path)


def test_identifiers_are_valid_in_matlab_and_unique() -> None:
    names = ["a.b", "a_b", "0.25ms", "time", "é", "_x", "n" * 70, "n" * 71]
    identified = identifiers(names)
    assert list(identified) == names
    assert len(set(identified.values())) == len(names)
    for name in identified.values():
        assert name.isidentifier()
        assert name.isascii()
        assert name[0].isalpha()
        assert len(name) <= 63

"""The study of measured machines: what is really there says NumPy; the others find what is known.

With the data of other people below `$FLEXHEX_DATA` (docs/measured-data.md), and always with a log
that is made here in the form of theirs.
"""

from __future__ import annotations

import json
import os
import sys
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.io import savemat
from scipy.signal import find_peaks

from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.prepare import Options
from studies.measured import others, ours
from studies.measured.__main__ import main
from studies.measured.sets import EMPS, SETS, Measured, emps
from studies.measured.sindy import sindy
from tests.compare import assert_close

Array = NDArray[np.float64]
TRUE = {"m": 95.0, "d": 200.0, "F_c": 20.0, "o": -3.0}


def write_emps(folder: Path) -> None:
    """Logs like those of EMPS of a machine that is known: back and forth, three times."""
    t = np.arange(18_001) * 1e-3
    rng = np.random.default_rng(2)
    for name, w in (("DATA_EMPS", 2 * np.pi / 6.0), ("DATA_EMPS_PULSES", 2 * np.pi / 4.5)):
        q = 0.12 - 0.1 * np.cos(w * t) - 0.02 * np.cos(3 * w * t)
        v, a = np.gradient(q, 1e-3), np.gradient(np.gradient(q, 1e-3), 1e-3)
        force = TRUE["m"] * a + TRUE["d"] * v + TRUE["F_c"] * np.tanh(v / 1e-3) + TRUE["o"]
        force = force + 0.5 * rng.standard_normal(len(t))
        read = q + 1e-7 * rng.standard_normal(len(t))
        channels = {"t": t, "qm": read, "qg": q, "vir": force / 35.0}
        columns = {key: value[:, None] for key, value in channels.items()}
        savemat(folder / f"{name}.mat", columns | {"gtau": 35.0})


def synthetic_emps(data: Path) -> Measured:
    """The set EMPS, with those logs."""
    folder = data / EMPS / "examples" / "EMPS" / "data"
    folder.mkdir(parents=True)
    write_emps(folder)
    return emps(data)


def test_every_method_finds_the_machine_of_a_made_log(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    synthetic_emps(tmp_path)
    assert main([str(tmp_path), "--only", "emps", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)["emps"]
    by = {method["tool"]: method for method in data["methods"]}
    assert set(by) >= {"flexhex identify", "least squares", "least squares, terms by BIC"}
    for name, true in TRUE.items():
        assert_close(by["least squares"][name], true, rtol=0.03, what=name)
        assert_close(by["flexhex identify"][name]["value"], true, rtol=0.03, what=name)
    for method in (by["flexhex identify"], by["least squares"]):
        assert max(*method["fit"], *method["test"]) < 0.03
    # BIC needs the three terms that are there
    assert {"sign v", "v", "1"} <= set(by["least squares, terms by BIC"]["terms"][0])


class Stlsq:
    """Sequentially thresholded least squares, as PySINDy's: small coefficients go, turn by turn."""

    def __init__(self, threshold: float) -> None:
        self.threshold = threshold

    def fit(self, X: Array, y: Array) -> Stlsq:
        self.coef_ = np.zeros((1, X.shape[1]))
        kept = np.ones(X.shape[1], dtype=bool)
        for _ in range(20):
            self.coef_[:] = 0.0
            self.coef_[0, kept] = np.linalg.lstsq(X[:, kept], y[:, 0], rcond=None)[0]
            kept = np.abs(self.coef_[0]) >= self.threshold
        return self


def test_pysindy_is_given_dry_friction_and_offset_as_it_is_given_the_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Columns of constant size, too, are scaled so that the threshold means the same for all."""
    monkeypatch.setitem(
        sys.modules, "pysindy", SimpleNamespace(__version__="stand-in", STLSQ=Stlsq)
    )
    row = sindy(synthetic_emps(tmp_path))
    assert row is not None
    assert {"1", "v", "sign v"} <= set(row["terms"][0])
    # at reversals, which the filter rounds, powers of the rate take a part of the dry friction
    for name, rtol in (("m", 0.02), ("F_c", 0.15), ("o", 0.05)):
        assert_close(row[name], TRUE[name], rtol=rtol, what=name)
    assert max(*row["fit"], *row["test"]) < 0.03


def test_a_missing_set_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path), "--only", "ur10e"]) == 3
    assert "docs/measured-data.md" in capsys.readouterr().err


@cache
def there(key: str) -> Measured:
    """A set of other people; skips where it is not to be had."""
    folder, read = SETS[key]
    data = Path(os.environ.get("FLEXHEX_DATA", "")) / folder
    if "FLEXHEX_DATA" not in os.environ or not data.is_dir():
        pytest.skip("FLEXHEX_DATA names no folder with the measured data")
    return read(data.parent)


def test_emps_rubs_more_one_way_at_speed_than_the_other() -> None:
    """Forces at constant speed, without any fit: half of their difference between the directions
    is friction, and it bends the other way in each."""
    (part,) = there("emps").fit
    r = others.rows(part, 40.0)
    steady = np.abs(r.a[:, 0]) < 0.02

    def force(low: float, high: float) -> float:
        on = steady & (r.v[:, 0] > low) & (r.v[:, 0] <= high)
        return float(r.tau[on].mean())

    def rise(sign: int) -> float:
        slow, fast = (sorted((sign * a, sign * b)) for a, b in ((0.04, 0.07), (0.1, 0.14)))
        return abs(force(*fast)) - abs(force(*slow))

    assert rise(-1) > 1.3 * rise(1)


def test_emps_is_what_is_in_print() -> None:
    measured = there("emps")
    model = others.usual(measured)
    published = measured.published
    for value, name in zip(model.p, ("m", "F_c", "d", "o"), strict=True):
        assert_close(value, published[name], rtol=0.02, what=name)
    assert_close(others.relative(measured, model, measured.fit)[0], published["error"], rtol=0.05)


def test_identify_holds_the_published_values_of_emps(tmp_path: Path) -> None:
    measured = there("emps")
    identified = identify(measured.logs(tmp_path)[0], options=Options(measured.base))
    for name in ("m", "d", "F_c", "o"):
        low, high = identified[f"{name}[1]"].estimate.ci95
        assert low <= measured.published[name] <= high, name


def test_ur10e_jumps_where_joints_turn_round_as_identified(tmp_path: Path) -> None:
    """Half of the jump of the torque at a reversal is dry friction, by no model."""
    measured = there("ur10e")
    model = ours.identified(measured, tmp_path)
    (part,) = [p for p in measured.fit if "30sec" in p.name]
    r = others.rows(part, 10.0)
    for axis in (3, 4, 5):
        v = r.v[:, axis]
        fast = 0.1 * np.abs(v).max()
        turns, _ = find_peaks(-np.abs(v), height=-0.3 * fast)
        jumps = []
        for at in turns:
            before, after = at - 1, at + 1
            while before > 0 and abs(v[before]) < fast and at - before < 30:
                before -= 1
            while after < len(v) - 1 and abs(v[after]) < fast and after - at < 30:
                after += 1
            if v[before] * v[after] < 0:
                viscous = model.result[f"d[{axis + 1}]"].estimate.value * (v[after] - v[before])
                jump = r.tau[after, axis] - r.tau[before, axis] - viscous
                jumps.append(jump / 2 / np.sign(v[after]))
        dry = model.result[f"F_c[{axis + 1}]"].estimate.value
        # inertia and load change a little from before to after
        assert_close(float(np.median(jumps)), dry, rtol=0.25, what=f"axis {axis + 1}")


def test_payload_of_the_ur10e_is_that_of_least_squares(tmp_path: Path) -> None:
    measured = there("ur10e")
    mass: Any = ours.payload(measured, tmp_path)
    assert mass is not None
    low, high = mass["ci95"]
    assert low <= others.payload_mass(measured) <= high


def test_wrist_of_the_tx40_is_coupled_and_one_run_cannot_tell(tmp_path: Path) -> None:
    measured = there("tx40")
    plain, both = (
        others.relative(measured, method(measured), measured.fit)
        for method in (others.usual, others.coupled)
    )
    assert both[4] < 0.4 * plain[4]
    assert both[5] < 0.5 * plain[5]
    assert_close(both[:4], plain[:4], rtol=0.2)
    assert ours.named(measured, tmp_path)["verdict"] == "cannot tell"

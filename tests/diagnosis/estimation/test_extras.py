"""Effects that a diagnosis found: fitted with all parameters, and in the FMU."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.found import read_diagnosis
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.estimation.inverse import left_out
from flexhex.diagnosis.prepare import Options
from flexhex.fmus.common.errors import UsageError
from flexhex.identify.inverse import write_fmu
from tests.compare import assert_close
from tests.diagnosis.estimation.test_inverse import TS, played

Array = NDArray[np.float64]
J, D, F_C, F_S, V_S, A, B, ORDER = 0.08, 0.3, 0.12, 0.06, 0.05, 0.03, -0.02, 14
WIDTH = 2e-6
"""Way [rad] within which friction of the effect turns over; that of the machine does so at once."""
FOUND = {
    "verdict": "named",
    "effects": [
        {"id": "viscous_friction", "axes": [1], "rivals": [], "parameters": {"d_v": {"value": 1}}},
        {
            "id": "stribeck_friction",
            "axes": [1],
            "rivals": ["load_friction"],
            "parameters": {
                "F_c": {"value": 0.2},
                "F_s": {"value": 0.1},
                "s_0": {"value": WIDTH},
                "v_s": {"value": V_S},
            },
        },
        {
            "id": "cogging_harmonic",
            "axes": [1],
            "rivals": [],
            "parameters": {
                "a": {"value": 0.1},
                "b": {"value": 0.1},
                "order": {"value": float(ORDER)},
            },
        },
    ],
}


def moved(t: Array, seed: int) -> tuple[Array, Array, Array]:
    """[rad], [rad/s], [rad/s2]; slow stretches among fast ones."""
    rng = np.random.default_rng(seed)
    w, phase = rng.uniform(0.8, 7.0, 5), rng.uniform(0, 2 * np.pi, 5)
    x = np.outer(t, w) + phase
    q, v = 0.35 / w * np.sin(x), 0.35 * np.cos(x)
    a = -0.35 * w * np.sin(x)
    return q.sum(axis=1), v.sum(axis=1), a.sum(axis=1)


def torque(q: Array, v: Array, a: Array) -> Array:
    """[N m], friction that turns over at once."""
    rubbed = np.sign(v) * (F_C + F_S * np.exp(-((v / V_S) ** 2)))
    return np.asarray(J * a + D * v + rubbed + A * np.cos(ORDER * q) + B * np.sin(ORDER * q))


def logs(folder: Path) -> list[Path]:
    paths, t = [], np.arange(0.0, 12.0, TS)
    for seed in (1, 2):
        noise = np.random.default_rng(10 + seed).standard_normal((len(t), 2)) * (1e-7, 2e-3)
        q, v, a = moved(t, seed)
        rows = np.column_stack([t, q + noise[:, 0], torque(q, v, a) + noise[:, 1]])
        paths.append(folder / f"{seed}.csv")
        head = "time,theta,tau_meas\ns,rad,N m"
        np.savetxt(paths[-1], rows, delimiter=",", header=head, comments="", fmt="%.10g")
    return paths


def written(folder: Path, data: Any) -> Path:
    path = folder / "diagnosis.json"
    path.write_text(data if isinstance(data, str) else json.dumps(data))
    return path


def test_gains_are_fitted_with_all_parameters_and_stand_in_the_fmu(tmp_path: Path) -> None:
    paths, file = logs(tmp_path), written(tmp_path, FOUND)
    identified = identify(paths[:1], paths[1:], options=Options("axis"), more=read_diagnosis(file))
    for name, true in {
        "J[1]": J,
        "d[1]": D,
        "stribeck_friction.F_c[1]": F_C,
        "stribeck_friction.F_s[1]": F_S,
        "cogging_harmonic.a[1]": A,
        "cogging_harmonic.b[1]": B,
    }.items():
        # 2 % of each, and what noise of 2 mN m and a reversal between two samples make
        assert identified[name].estimate.value == pytest.approx(
            true, abs=0.02 * abs(true) + 2e-4
        ), name
        assert identified[name].determined, name
    assert "F_c[1]" not in [one.name for one in identified.parameters]
    assert any(
        "stribeck_friction is indistinguishable from load_friction" in n for n in identified.notes
    )
    alone = identify(paths[:1], paths[1:], options=Options("axis"))
    assert alone.held_out is not None
    assert identified.held_out is not None
    assert alone.held_out.fitted[0] > 0.06
    assert identified.held_out.fitted[0] < 0.01

    q, v, a = moved(np.arange(0.0, 4.0, TS), 3)
    fmu = write_fmu(tmp_path / "inverse.fmu", identified)
    got = played(fmu, q[:, None], v[:, None], a[:, None])
    wanted = torque(q, v, a)[1:-1]
    # not at a reversal, which lies between two samples, nor at the first one, before any way
    away = np.abs(v[1:-1]) > 0.05
    away[0] = False
    assert_close(got[away, 0], wanted[away], atol=0.01 * np.abs(wanted).max(), what="tau_ff")


def test_a_shape_that_is_known_roughly_is_fitted_with_its_interval(tmp_path: Path) -> None:
    found = json.loads(json.dumps(FOUND))
    found["effects"][2]["parameters"]["order"] = {"value": ORDER + 0.2, "ci95": [13.8, 14.6]}
    more = read_diagnosis(written(tmp_path, found))
    identified = identify(logs(tmp_path)[:1], options=Options("axis"), more=more)
    order = identified["cogging_harmonic.order[1]"].estimate
    # half as far off as it was given, though friction of the runs has another form
    assert abs(order.value - ORDER) < 0.1
    assert order.ci95[0] < ORDER < order.ci95[1] < order.ci95[0] + 0.3
    fmu = write_fmu(tmp_path / "inverse.fmu", identified)
    turned = np.linspace(0.0, 0.8, 60)[:, None]
    got = played(fmu, turned, np.full((60, 1), 0.8 / 59 / TS), np.zeros((60, 1)))[:, 0]
    wanted = A * np.cos(ORDER * turned[1:-1, 0]) + B * np.sin(ORDER * turned[1:-1, 0])
    apart = got[20:] - wanted[20:]  # beyond the way over which friction turns over
    assert np.ptp(apart) < 0.1 * np.ptp(wanted)


@pytest.mark.filterwarnings("error")
def test_a_shape_that_other_runs_had_is_fitted_too(tmp_path: Path) -> None:
    """A rate far beyond those of these runs, at which Stribeck's friction is Coulomb's."""
    found = json.loads(json.dumps(FOUND))
    found["effects"][1]["parameters"]["v_s"] = {"value": 9e9, "ci95": [8e9, 10e9]}
    more = read_diagnosis(written(tmp_path, found))
    identified = identify(logs(tmp_path)[:1], options=Options("axis"), more=more)
    assert np.isfinite([one.estimate.value for one in identified.parameters]).all()
    assert identified["J[1]"].estimate.value == pytest.approx(J, rel=0.05)


def test_parameters_of_an_effect_can_be_tuned_in_the_fmu(tmp_path: Path) -> None:
    paths, file = logs(tmp_path), written(tmp_path, FOUND)
    fmu = write_fmu(
        tmp_path / "inverse.fmu",
        identify(paths[:1], options=Options("axis"), more=read_diagnosis(file)),
    )
    still = np.full((60, 1), 0.2), np.zeros((60, 1)), np.zeros((60, 1))
    names = [f"p.{one}[1]" for one in ("cogging_harmonic.a", "cogging_harmonic.order")]
    one, other = (
        played(fmu, *still, start=dict(zip(names, values, strict=True)))[-1, 0]
        for values in ((1.0, 14.0), (2.0, 7.0))
    )
    # b stays as it was fitted
    wanted = 2 * np.cos(1.4) - np.cos(2.8) + B * (np.sin(1.4) - np.sin(2.8))
    assert other - one == pytest.approx(wanted, abs=1e-3)


def test_what_drifts_is_fitted_and_left_out_of_the_fmu(tmp_path: Path) -> None:
    effect = {
        "id": "offset_drift",
        "axes": [1],
        "rivals": [],
        "parameters": {"o_r": {"value": 0.1}, "T": {"value": 200.0}},
    }
    data = {"verdict": "named", "effects": [effect]}
    extras = read_diagnosis(written(tmp_path, data))
    assert [one.effect.id for one in extras.listed] == ["offset_drift"]
    assert left_out(extras) == [
        "offset_drift of axis 1 is not in the FMU: it drifts with the time of a run"
    ]


@pytest.mark.parametrize(("id", "said"), [
    ("torque_saturation", "torque_saturation is not fitted: a drive at its limit"),
    ("encoder_eccentricity", "encoder_eccentricity is not fitted: the feedback follows the angle"),
    ("gravity_tilt", "gravity_tilt is not fitted: it is no torque of the motion alone"),
    ("cogging_harmonic", "cogging_harmonic is not fitted on axis 1: it has no values there"),
    ("wobble", "wobble is not fitted: no effect of the library"),
])  # fmt: skip
def test_what_is_no_torque_of_the_motion_is_said(id: str, said: str, tmp_path: Path) -> None:
    effect = {"id": id, "axes": [1], "rivals": [], "parameters": {}}
    extras = read_diagnosis(written(tmp_path, {"verdict": "named", "effects": [effect]}))
    assert not extras.listed
    assert extras.notes[0].startswith(said)


def test_effect_that_an_axis_has_twice_is_fitted_twice(tmp_path: Path) -> None:
    values = {"a": 1, "b": 2, "order": 7, "a#2": 3, "b#2": 4, "order#2": 9}
    effect = {
        "id": "cogging_harmonic",
        "axes": [2],
        "rivals": [],
        "parameters": {name: {"value": value} for name, value in values.items()},
    }
    extras = read_diagnosis(written(tmp_path, {"verdict": "named", "effects": [effect]}))
    assert [(one.parameter("a"), one.shape) for one in extras.listed] == [
        ("cogging_harmonic.a[2]", {"order": 7.0}),
        ("cogging_harmonic_2.a[2]", {"order": 9.0}),
    ]
    with pytest.raises(UsageError, match="on axis 2, the base model has 1: diagnose these logs"):
        identify(logs(tmp_path)[:1], options=Options("axis"), more=extras)


@pytest.mark.parametrize(("data", "said"), [
    ("no json", "is no diagnosis"),
    ({"parameters": []}, "is no diagnosis"),
    ([1], "is no diagnosis"),
    ({"effects": [{"id": "cogging_harmonic"}]}, "is no diagnosis"),
])  # fmt: skip
def test_other_files_are_refused(data: Any, said: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=said):
        read_diagnosis(written(tmp_path, data))


@pytest.mark.parametrize("verdict", ["none", "cannot tell"])
def test_diagnosis_that_names_nothing_adds_nothing_and_says_so(
    verdict: str, tmp_path: Path
) -> None:
    """`diagnose && identify --diagnosis`: the first ends with 0 where nothing is missing."""
    read = read_diagnosis(written(tmp_path, {"verdict": verdict, "effects": []}))
    assert not read.listed
    assert not read.changed
    assert f"verdict `{verdict}`" in read.notes[0]


def test_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no such file"):
        read_diagnosis(tmp_path / "nothing.json")

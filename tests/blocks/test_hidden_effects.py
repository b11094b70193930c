"""Hidden effects of machine.fmu: each does what its truth file says, checked in plain NumPy."""

from __future__ import annotations

import ctypes
import tempfile
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.fmugen.compile import compile_object, link_shared
from flexhex.fmus.common.errors import MachineError
from flexhex.fmus.machine.truth import KINDS, WIDTH, Hidden, load_truth
from tests.conftest import MACHINE_FILE, OBJECTS, ROOT

Array = NDArray[np.float64]
TS, N = 0.00025, 6
WRAPPER = """
#define PLANT_N 6
#define PLANT_N_HIDDEN 1
typedef struct {{ double Ts; double hidden_effects[6]; }} plant_parameters;
#include "{header}"
void along(const plant_parameters *p, long count, const double *theta, const double *tau,
           double *torque) {{
  hidden_motion m;
  hidden_motion_start(&m);
  for (long k = 0; k < count; ++k) {{
    hidden_effects(p, &m, theta + 6 * k, tau + 6 * k, torque + 6 * k);
  }}
}}
"""
SIZES = {
    "lugre": (0.02, 0.03, 0.05, 20.0),
    "cubic": (2.0,),
    "cable": (0.3, 0.05, -1.0),
    "saturation": (20.0,),
    "harmonic": (0.01, 250.0, 0.7),
    "drag": (0.1,),
    "ripple": (0.01, 36.0, 0.4),
    "bump": (0.02, 0.03, 0.01),
    "inertia": (0.002, 12.0, 0.3),
}
AXIS = 2


@pytest.fixture(scope="module")
def library() -> ctypes.CDLL:
    header = ROOT / "fmus" / "machine" / "hidden_effects.h"
    with tempfile.TemporaryDirectory(dir=OBJECTS) as folder:
        source = Path(folder) / "hidden.c"
        source.write_text(WRAPPER.format(header=header), encoding="utf-8")
        compiled = compile_object(source, header.read_text(encoding="utf-8"), OBJECTS)
        return ctypes.CDLL(str(link_shared([compiled], Path(folder) / "hidden.so")))


def hidden(kind: str) -> Hidden:
    given = zip(KINDS[kind], SIZES[kind], strict=True)
    tables = {n: {"value": v, "unit": unit, "source": "assumed"} for (n, unit), v in given}
    return Hidden.model_validate({"kind": kind, "axes": (AXIS + 1,), "values": tables})


def motion() -> tuple[Array, Array, Array, Array]:
    """theta (samples, 6) of half a second, exact rate and acceleration, torque."""
    t = TS * np.arange(2000)[:, None]
    f = 2 * np.pi * np.linspace(0.8, 1.6, N)
    tau = 1.5 + np.cos(9 * t) * np.linspace(0.5, 1.5, N)
    return 0.15 * np.sin(f * t), 0.15 * f * np.cos(f * t), -0.15 * f**2 * np.sin(f * t), tau


def torque(library: ctypes.CDLL, kind: str) -> Array:
    theta, _, _, tau = motion()
    p, torques = np.array([TS, *hidden(kind).rows()]), np.zeros_like(theta)
    pointers = [ctypes.c_void_p(a.ctypes.data) for a in (p, theta, tau, torques)]
    library.along(pointers[0], ctypes.c_long(len(theta)), *pointers[1:])
    return torques


def expected(kind: str) -> Array:
    theta, rate, rise, tau = (v[:, AXIS] for v in motion())
    v = SIZES[kind]
    if kind == "lugre":
        return bristles(theta)
    forms = {
        "cubic": lambda: v[0] * theta**3,
        "cable": lambda: -v[0] * np.maximum(0.0, v[1] - theta),
        "saturation": lambda: tau / (1 + (v[0] / tau) ** 2),
        "harmonic": lambda: v[0] * np.cos(v[1] * theta + v[2]),
        "drag": lambda: v[0] * rate * np.abs(rate),
        "ripple": lambda: v[0] * tau * np.cos(v[1] * theta + v[2]),
        "bump": lambda: v[0] * np.exp(-(((theta - v[1]) / v[2]) ** 2)),
        "inertia": lambda: (
            v[0] * np.sin(v[1] * theta + v[2]) * rise
            + v[0] * v[1] / 2 * np.cos(v[1] * theta + v[2]) * rate**2
        ),
    }
    return np.asarray(forms[kind]())


def bristles(theta: Array) -> Array:
    """LuGre by 20 Euler steps a tick along straight lines between the samples."""
    F_c, F_s, v_s, sigma = SIZES["lugre"]
    z, steps, torques = 0.0, 20, [0.0]
    for delta in np.diff(theta):
        rate = delta / TS
        level = F_c + (F_s - F_c) * np.exp(-((rate / v_s) ** 2))
        for _ in range(steps):
            z += TS / steps * (rate - sigma * abs(rate) / level * z)
        torques.append(sigma * z)
    return np.array(torques)


@pytest.mark.parametrize("kind", KINDS)
def test_hidden_effect_is_its_formula(library: ctypes.CDLL, kind: str) -> None:
    actual, wanted = torque(library, kind), expected(kind)
    # rates lag by half a tick, accelerations by one: 1e-3 rad of phase; the cable's corner is
    # round over 4 mrad, 0.3 N m/rad * 2 mrad at its worst
    tolerance = 7e-4 if kind == "cable" else 4e-3 * np.abs(wanted).max()
    np.testing.assert_allclose(actual[3:, AXIS], wanted[3:], rtol=0, atol=tolerance)
    assert np.abs(wanted).max() > 50 * tolerance or kind == "cable"
    assert not actual[:, np.arange(N) != AXIS].any(), "other axes must not feel it"


def test_hidden_effects_come_from_the_truth_file(tmp_path: Path) -> None:
    text = MACHINE_FILE.with_name("tflex-truth.toml").read_text(encoding="utf-8")
    path = tmp_path / "x-truth.toml"
    entry = '\n[[hidden]]\nkind = "cubic"\naxes = [2, 5]\n[hidden.values]\n'
    path.write_text(text + entry + 'k = { value = 2.0, unit = "N m/rad3", source = "assumed" }\n')
    (effect,) = load_truth(path).hidden
    rows = np.array(effect.rows()).reshape(-1, WIDTH)
    np.testing.assert_array_equal(rows[:, :3], [[1, 1, 2.0], [1, 4, 2.0]])
    assert load_truth(MACHINE_FILE.with_name("tflex-truth.toml")).hidden == ()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"cubic"', '"magic"', "kind must be one of lugre"),
        ("k = {", "q = {", "cubic has the values k"),
        ("N m/rad3", "N m", "is in 'N m', wanted 'N m/rad3'"),
    ],
)
def test_wrong_hidden_effect_is_one_clear_message(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    text = MACHINE_FILE.with_name("tflex-truth.toml").read_text(encoding="utf-8")
    entry = '\n[[hidden]]\nkind = "cubic"\naxes = [2]\n[hidden.values]\n'
    entry += 'k = { value = 2.0, unit = "N m/rad3", source = "assumed" }\n'
    path = tmp_path / "x-truth.toml"
    path.write_text(text + entry.replace(old, new))
    with pytest.raises(MachineError, match=message):
        load_truth(path)

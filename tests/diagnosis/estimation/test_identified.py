"""Parameters of any base model: intervals hold what the machine has, sums are the textbook's."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from flexhex.diagnosis.estimation.bodies import TEN, consistent
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.prepare import Options
from flexhex.diagnosis.result.estimates import summed
from flexhex.fmus.common.errors import LogError
from flexhex.init import two_links as example
from tests.compare import assert_close
from tests.diagnosis import lwa4p, sliding, two_links
from tests.diagnosis.estimation import machines

Array = NDArray[np.float64]
OWN = f"{example.__file__}:TwoLinks"
TRUE = {
    "link_1.mc": 3.0 * 0.18,
    "link_1.J": 0.05 + 3.0 * 0.18**2,
    "link_2.m": 2.0,
    "link_2.mc": 2.0 * 0.15,
    "link_2.J": 0.03 + 2.0 * 0.15**2,
}
"""Of `tests.diagnosis.two_links`, by hand."""
FRICTION = (0.8, 0.5)


def arm(folder: Path, seeds: tuple[int, ...], change: float = 1.0) -> list[Path]:
    """Runs of the two links with dry friction; change: factor of the reported torque."""
    paths = []
    for seed in seeds:
        run = two_links.run(seed, 1, 0.0, (0.0, 0.0))
        _, rate, _ = two_links.moved(run["time"], seed)
        tau = change * (run["tau_meas"] + machines.rubbed(rate, FRICTION, (0.0, 0.0)))
        head = f"# trajectory: {seed}\n"
        path = folder / f"arm-{seed}.csv"
        paths.append(machines.write(path, run["time"], run["theta"], tau, (False,) * 2, head, seed))
    return paths


@pytest.fixture(scope="module")
def links(tmp_path_factory: pytest.TempPathFactory) -> Identified:
    paths = arm(tmp_path_factory.mktemp("links"), (1, 2, 3))
    return identify(paths[:2], paths[2:], options=Options(OWN))


def covered(identified: Identified, name: str, value: float) -> bool:
    low, high = identified[name].estimate.ci95
    return low <= value <= high


def test_intervals_of_an_own_base_hold_the_machine(links: Identified) -> None:
    names = [*TRUE, "F_c[1]", "F_c[2]"]
    true = {**TRUE, "F_c[1]": FRICTION[0], "F_c[2]": FRICTION[1]}
    assert [name for name in names if not covered(links, name, true[name])] == []
    # and say something, where the runs do
    determined = [name for name in names if links[name].determined]
    assert determined == ["link_2.mc", "link_2.J", "F_c[1]", "F_c[2]"]
    for name in determined:
        low, high = links[name].estimate.ci95
        assert high - low < 0.01 * true[name], name


def test_sums_of_two_links_are_those_of_the_textbook(links: Identified) -> None:
    # the second mass hangs on the end of the first link, 0.4 m away
    sums = {one.name for one in links.combinations}
    assert sums == {
        "link_1.mc + 0.4 link_2.m",
        "link_1.J + 0.16 link_2.m",
        "link_2.mc",
        "link_2.J",
    }
    (mc,) = [one for one in links.combinations if one.name == "link_1.mc + 0.4 link_2.m"]
    assert_close(mc.estimate.value, TRUE["link_1.mc"] + 0.4 * 2.0, rtol=0.003)
    assert mc.determined
    assert not links["link_2.m"].determined


def test_errors_on_held_out_runs_are_those_of_the_noise(links: Identified) -> None:
    assert links.held_out is not None
    # noise of the torque: 0.02 N m and 0.5 %, smoothed over 16 samples
    assert (links.held_out.fitted < 0.006).all()
    assert (links.held_out.file > 5 * links.held_out.fitted).all()


def test_parameters_that_are_exact_stay_exact(tmp_path: Path) -> None:
    text = Path(example.__file__).read_text()
    (tmp_path / "base.py").write_text(text.replace('"kg", 2.0, 0.1)', '"kg", 2.0, 0)'))
    identified = identify(
        arm(tmp_path, (1, 2)), options=Options(f"{tmp_path / 'base.py'}:TwoLinks")
    )
    assert identified["link_2.m"].estimate.ci95 == (2.0, 2.0)
    assert (identified.errors.fitted < 0.006).all()
    assert covered(identified, "link_1.mc", TRUE["link_1.mc"])
    assert identified["link_1.mc"].determined


def test_bodies_of_a_file_with_exact_values_come_to_an_end() -> None:
    pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
    runs = [lwa4p.FILE.with_name(f"run_{number}.csv") for number in ("001", "040")]
    identified = identify(runs, options=Options(str(lwa4p.FILE)))
    assert np.isfinite(identified.errors.fitted).all()
    assert identified["link_2.m"].exact
    assert not identified["J_r[1]"].exact
    # its values are known, but tell no acceleration: motors without rotors have no mass
    assert identified.simulation is not None
    for k in range(1, 7):
        ten = np.array([identified[f"link_{k}.{name}"].estimate.value for name in TEN])
        assert consistent(ten), k


def test_terms_are_written_as_they_are_read() -> None:
    terms = (("a.m", 1.0), ("b.m", -0.31), ("c.J", 1.0))
    assert summed(terms) == "a.m - 0.31 b.m + c.J"
    assert summed((("a.m", -1.0),)) == "-a.m"
    assert summed(terms, 1) == "a.m + 2 more"


def test_linear_axis_of_unknown_mass(tmp_path: Path) -> None:
    paths = sliding.write(tmp_path / "axis", ("m", "N"), friction=(0.2,))
    identified = identify(paths[:4], paths[4:], options=Options("axis"))
    true = {"k[1]": sliding.SPRING, "o[1]": sliding.OFFSET}
    assert [name for name, value in true.items() if not covered(identified, name, value)] == []
    # nine of twelve other draws hold the mass in its interval: friction is of another form
    assert_close(identified["m[1]"].estimate.value, sliding.MASS, rtol=1e-3)
    assert identified["m[1]"].estimate.unit == "kg"
    # LuGre: its friction when fast is 0.2 N, when slow 20 % more, which Coulomb and viscous share
    assert_close(identified["F_c[1]"].estimate.value, 0.2, rtol=0.01)
    assert_close(identified["d[1]"].estimate.value, sliding.DAMPING, rtol=0.01)
    assert [one.name for one in identified.parameters].count("d[1]") == 1


@pytest.fixture(scope="module")
def cart(tmp_path_factory: pytest.TempPathFactory) -> tuple[Identified, mujoco.MjModel]:
    """The cart of MuJoCo, whose bodies weigh 6 % more or less than its file says, identified from
    two runs without and one with 0.8 kg."""
    pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
    folder = tmp_path_factory.mktemp("cart")
    (folder / "cart.xml").write_text(machines.CART)
    model = machines.heavier(machines.CART)
    loaded = machines.heavier(machines.CART)
    loaded.body_mass[4] += 0.8  # of the grip, at its centre
    paths = machines.cart_runs(folder, model, (1, 2, 3))
    paths[2:2] = machines.cart_runs(folder, loaded, (4,), "# payload: 0.8 kg\n")
    options = Options(str(folder / "cart.xml"))
    return identify(paths[:3], paths[3:], options=options), model


def true_ten(model: mujoco.MjModel, body: int, at: Array) -> Array:
    """The ten parameters of a body of MuJoCo about a point of its frame, in its directions."""
    R = np.empty(9)
    mujoco.mju_quat2Mat(R, model.body_iquat[body])
    R = R.reshape(3, 3)
    m, c = model.body_mass[body], model.body_ipos[body] - at
    J = R * model.body_inertia[body] @ R.T + m * (c @ c * np.eye(3) - np.outer(c, c))
    return np.array([m, *(m * c), J[0, 0], J[0, 1], J[1, 1], J[0, 2], J[1, 2], J[2, 2]])


def test_intervals_of_a_robots_file_hold_the_machine(
    cart: tuple[Identified, mujoco.MjModel],
) -> None:
    identified, model = cart
    tens = [true_ten(model, k, model.jnt_pos[k - 1]) for k in (1, 2, 3)]
    # the grip is fixed to the wrist, 0.2 m below it
    tens[2] += true_ten(model, 4, np.array([0.0, 0.0, 0.2]))
    true = {
        f"{body}.{name}": value
        for body, ten in zip(("cart", "arm", "wrist"), tens, strict=True)
        for name, value in zip(TEN, ten, strict=True)
    }
    true |= dict(zip(("m_r[1]", "J_r[2]", "J_r[3]"), machines.ROTORS, strict=True))
    for name, values in (("F_c", machines.DRY), ("d", machines.VISCOUS), ("o", machines.OFFSETS)):
        true |= {f"{name}[{k + 1}]": value for k, value in enumerate(values)}
    del true["o[1]"]
    true |= {"payload 0.8 kg.m": 0.8, "payload 0.8 kg.mc_z": -0.16, "payload 0.8 kg.mc_x": 0.0}
    missed = [name for name, value in true.items() if not covered(identified, name, value)]
    # one in twenty of 95 % intervals
    assert len(missed) <= 0.1 * len(true), missed
    sums = [
        (one, sum(factor * true[name] for name, factor in one.terms))
        for one in identified.combinations
    ]
    # half widths of intervals: of 13, more than 3 lie beyond one in 1 of 250 cases
    off = [
        abs(one.estimate.value - value) / (one.estimate.ci95[1] - one.estimate.value)
        for one, value in sums
    ]
    assert sum(size > 1 for size in off) <= 3
    assert max(off) < 2
    carried = next(one for one, _ in sums if one.name == "cart.m + arm.m + wrist.m")
    assert carried.determined
    assert identified["payload 0.8 kg.m"].determined
    # a point mass: the best fit lies beside all bodies
    payload = np.array([identified[f"payload 0.8 kg.{name}"].estimate.value for name in TEN])
    assert consistent(payload)
    assert any(note.startswith("payload 0.8 kg: the best fit") for note in identified.notes)
    # gravity along the straight rail is a constant, too
    assert "o[1]" not in {one.name for one in identified.parameters}
    assert any("offset of axis 1" in note for note in identified.notes)


def test_errors_of_a_robots_file_are_those_of_the_noise(
    cart: tuple[Identified, mujoco.MjModel],
) -> None:
    identified, _ = cart
    assert identified.held_out is not None
    # half a percent of noise, smoothed over 16 samples, and what it makes of the parameters
    assert (identified.held_out.fitted < 0.01).all()


def test_a_body_that_cannot_be_is_never_said(tmp_path: Path) -> None:
    """Torques of the last axis against its acceleration ask for a negative inertia."""
    pytest.importorskip("pinocchio", reason="the extra `robots` is not installed")
    (tmp_path / "cart.xml").write_text(machines.CART)
    paths = machines.cart_runs(tmp_path, machines.heavier(machines.CART), (1, 2))
    for path in paths:
        head, units, *rows = path.read_text().splitlines()[1:]
        values = np.array([[float(v) for v in row.split(",")] for row in rows])
        # a torque that goes with the acceleration the wrong way, as a filter's lag makes it
        rate = np.gradient(values[:, 3], values[:, 0])
        values[:, 6] -= 0.07 * np.gradient(rate, values[:, 0])
        text = "\n".join(",".join(f"{v:.9g}" for v in row) for row in values)
        path.write_text(f"# trajectory: {path.stem}\n{head}\n{units}\n{text}\n")
    wide = {"mass": 1.0, "inertia": 1.0, "centre": 0.5}
    identified = identify(paths, options=Options(str(tmp_path / "cart.xml"), tolerance=wide))
    for body in ("cart", "arm", "wrist"):
        assert consistent(np.array([identified[f"{body}.{n}"].estimate.value for n in TEN]))
    axes = [
        one for one in identified.parameters if one.name.startswith(("F_c", "d[", "J_r", "m_r"))
    ]
    assert len(axes) == 9
    for one in axes:
        assert one.estimate.value >= 0, one.name
        assert one.estimate.ci95[0] >= 0, one.name
    assert any("values that no machine has" in note for note in identified.notes)


def test_torques_of_another_sign_are_refused(tmp_path: Path) -> None:
    paths = arm(tmp_path, (1, 2), change=-1.0)
    with pytest.raises(LogError, match="with all torques negated"):
        identify(paths, options=Options(OWN))

"""How near good runs come to the limits of the rules: the table of docs/gateway-figures.md."""

from __future__ import annotations

import tomllib
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.gateway.bench import Bench
from tests.gateway.cargo import GATEWAY
from tests.gateway.fault_table import MARGINS, Margin, Table
from tests.gateway.weight import free
from tests.sampling import draw

SEEDS = (1, 2, 3)
SECONDS = 10.0
HALF = 50
"""No good run may come nearer to a default limit than this share of it [%]."""
LIMITS = {
    "torque": ("limits", "torque_N_m", "N m"),
    "torque_step": ("limits", "torque_step_N_m", "N m"),
    "measured_torque": ("limits", "measured_torque_N_m", "N m"),
    "feedback_torque": ("limits", "feedback_torque_N_m", "N m"),
    "thermal": ("limits", "rated_torque_N_m", "N m"),
    "jump": ("limits", "jump_rad", "rad"),
    "speed": ("limits", "speed_rad_per_s", "rad/s"),
    "following_error": ("limits", "following_error_rad", "rad"),
    "estimate.range": ("estimate", "range", "scales"),
    "estimate.innovation": ("estimate", "innovation_N_m", "N m"),
}
NEVER = {"K.t_start": 1e6}
"""The estimator does not begin: its first values stay."""


def estimates(ssp: Path) -> list[str]:
    """Names of the first values of the estimator."""
    with (
        zipfile.ZipFile(ssp) as archive,
        archive.open("resources/estimator.fmu") as inner,
        zipfile.ZipFile(inner) as fmu,
    ):
        root = ElementTree.fromstring(fmu.read("modelDescription.xml"))
    names = (v.attrib["name"] for v in root.iter("ScalarVariable"))
    return [name for name in names if name.startswith("p0.")]


def shares(
    ssp: Path, folder: Path, parameters: dict[str, float], seed: int, *more: tuple[str, str]
) -> dict[str, float]:
    """Largest shares of the limits in a run of the simulated real machine."""
    lines = "".join(f'"{name}" = {value}\n' for name, value in parameters.items())
    changes = (*more, ("\n[bus]", f"\n[system.parameters]\n{lines}\n[bus]"))
    options = f'plant.parameters = {{ "plant.seed" = {seed} }}\n'
    fallen = free(Bench(ssp, folder), options, changes=changes, seconds=SECONDS)
    assert fallen.ran.code == 0, fallen.ran.words
    shares_of_limits: dict[str, float] = fallen.ran.one("summary")["share_of_limits"]
    return shares_of_limits


@pytest.fixture(scope="session")
def margins(request: pytest.FixtureRequest) -> Table:
    """The table of the guide."""
    return Table(bool(request.config.getoption("--update")), MARGINS)


def test_good_runs_stay_away_from_the_limits(
    machine_ssp: Path, tmp_path: Path, margins: Table
) -> None:
    """Noise, friction and cogging of the simulated real machine, with lift-off and landing.

    The table is of all seeds.
    """
    seeds = draw(SEEDS, 1, "noise of good runs")
    adaptive = [shares(machine_ssp, tmp_path, {}, seed) for seed in seeds]
    fixed = shares(machine_ssp, tmp_path, NEVER, SEEDS[0])
    none = NEVER | dict.fromkeys([f"K.{name}" for name in estimates(machine_ssp)], 0.0)
    unjudged = ("feedback_torque_N_m = 0.6", "feedback_torque_N_m = 0.0")
    alone = shares(machine_ssp, tmp_path, none, SEEDS[0], unjudged)
    config = tomllib.loads((GATEWAY / "machines" / "akd.toml").read_text())
    seen = 0
    for rule, (table, key, unit) in LIMITS.items():
        most = {k: max(run.get(rule, 0.0) for run in adaptive) for k in adaptive[0]}.get(rule)
        cells = [most, fixed.get(rule), alone.get(rule)]
        rounded = tuple(None if cell is None else round(100 * cell) for cell in cells)
        if len(seeds) == len(SEEDS):
            margins.add(Margin(rule, f"{config[table][key]:g} {unit}", rounded))
        seen += sum(share is not None for share in rounded)
        # feedback alone has a large error by design
        assert all(share <= HALF for share in rounded[:2] if share is not None), (rule, rounded)
    assert seen > 20
    margins.write()

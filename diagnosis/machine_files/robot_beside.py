"""What was identified of a robot and its own file has no place for, as the TOML that stands beside
it: rotors, dry friction in its form, offsets, effects. `--base` of that TOML is the whole model.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexhex.diagnosis.basemodels.robots import RobotBase
from flexhex.diagnosis.estimation.friction import PARAMETER
from flexhex.diagnosis.estimation.records import Identified
from flexhex.diagnosis.kinds import Kind
from flexhex.diagnosis.machine_files.toml_text import toml_text
from flexhex.diagnosis.result.estimates import Parameter
from flexhex.diagnosis.result.verdict import NORMAL
from flexhex.fmus.common.effects import Effect, library
from flexhex.fmus.common.user_code import relative

Table = dict[str, Any]
HEAD = "What `flexhex identify` found"
"""The first words of such a file."""
VAGUE = 10.0
"""Relative deviation beyond which a rotor's inertia stays free: the largest that the TOML takes."""
OWN = ("coulomb_friction", "torque_offset")
"""Effects of every identification that a robot's file has no whole place for: it has no form of
friction."""


def written_by_us(path: Path) -> bool:
    """Whether a TOML or JSON is one that was written here."""
    text = path.read_text(encoding="utf-8", errors="replace")
    return text.startswith(f"# {HEAD}") if path.suffix == ".toml" else '"unobservable":' in text


def beside_text(path: Path, written: Path, identified: Identified) -> tuple[str, set[str]]:
    """The TOML at `path`, beside the robot's file that was `written`; and the parameters in it."""
    estimated = identified.estimated
    base, found = estimated.model.base, {one.name: one for one in identified.parameters}
    assert isinstance(base, RobotBase)
    more, robot = base.robot.more, base.robot
    tables: dict[str, Any] = {"robot": written.name, "joints": list(robot.joints)}
    if more.gravity is not None:
        tables["gravity"] = list(more.gravity)
    known = more.tolerance
    tables["tolerance"] = {key: getattr(known, key) for key in sorted(known.model_fields_set)}
    tables["rotor"], there = {}, set[str]()
    for axis, (joint, kind) in enumerate(zip(robot.joints, base.kinds, strict=True), start=1):
        name = f"{kind.inertia}_r[{axis}]"
        rotor = found[name].estimate
        said, wide = more.rotor.get(joint), (rotor.ci95[1] - rotor.value) / NORMAL
        if wide <= VAGUE * rotor.value:
            told = {"inertia": rotor.value}
            if said is not None and said.tolerance is not None:
                told["tolerance"] = said.tolerance
            elif wide > known.inertia * rotor.value:
                # one that is known better may be another tomorrow, as a body may
                told["tolerance"] = wide / rotor.value
            tables["rotor"][joint] = told
            there.add(name)
    if more.tool is not None:
        tables["tool"] = more.tool.model_dump()
    effects = list[Table]()
    for i, form in enumerate(estimated.forms):
        for id in OWN:
            one = found.get(f"{PARAMETER[id]}[{i + 1}]")
            if one is not None and one.estimate.value:
                effect = library()[id]
                shape = form.shape if effect.shapes else {}
                effects.append(_entry(effect, i, base.kinds[i], [one], shape, path.parent))
                there.add(one.name)
    for extra in estimated.extras.listed:
        gains = [found[extra.parameter(gain.name)] for gain in extra.effect.gains]
        shape = {name: _moved(found, extra.parameter(name), v) for name, v in extra.shape.items()}
        kind = base.kinds[extra.axis]
        effects.append(_entry(extra.effect, extra.axis, kind, gains, shape, path.parent))
        names = *(gain.name for gain in extra.effect.gains), *extra.shape
        there |= {extra.parameter(name) for name in names}
    runs = ", ".join(Path(run).name for run in identified.runs)
    head = [
        f"{HEAD} beside {written.name}: --base {path.name} has both.",
        f"From {runs}.",
    ]
    return toml_text({k: v for k, v in tables.items() if v}, {"effects": effects}, head), there


def _moved(found: Mapping[str, Parameter], name: str, value: float) -> float:
    """A shape that was estimated, or as it was."""
    return found[name].estimate.value if name in found else float(value)


def _entry(
    effect: Effect,
    axis: int,
    kind: Kind,
    gains: list[Parameter],
    shape: Mapping[str, float],
    folder: Path,
) -> Table:
    """An effect on an axis, from 0; folder: from which a user's own is seen."""
    tables: Table = {}
    for gain, one in zip(effect.gains, gains, strict=True):
        value, (low, high) = one.estimate.value, one.estimate.ci95
        # noise alone may have pushed it beyond what a machine can have
        value = max(value, 0.0) if gain.low == 0 else value
        value = min(value, gain.high) if gain.unit == "1" else value
        table: Table = {"value": value, "unit": kind.unit(gain.unit), "source": "fitted"}
        if math.isfinite(low) and math.isfinite(high):
            table["ci95"] = [low, high]
        tables[gain.name] = table
    aside = {one.name for one in effect.shapes if one.aside}
    tables |= {name: value for name, value in shape.items() if name not in aside}
    return {
        "id": relative(effect.origin or effect.id, folder),
        "axes": [axis + 1],
        "parameters": tables,
    }

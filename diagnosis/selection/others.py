"""Base parameters that may be others than the machine file says."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from flexhex.diagnosis.regression.calibrate import Calibrated
from flexhex.diagnosis.regression.payloads import GROUP
from flexhex.diagnosis.selection.changed import ChangedParameter, HeavierBody, WrongFile

MASSES = ("kg", "kg m", "kg m2")
"""Units of what a body's mass scales."""
FRAMES = ("m", "rad")
"""Units of errors of the geometry."""


def others(model: Calibrated) -> Sequence[ChangedParameter]:
    """Base parameters that have a tolerance, all of a body, of its geometry or of a group together,
    the mass of a body with its moments, and all of them."""
    single, bodies = list[ChangedParameter](), dict[str, list[int]]()
    for place, known in enumerate(model.known):
        if 0 < known.tolerance < np.inf and known.group not in ("history", "delay", GROUP):
            single.append(ChangedParameter(known.name, (place,), known.axis))
            owner, dot, _ = known.name.rpartition(".")
            if dot:
                bodies.setdefault(owner, []).append(place)
            if known.group not in (known.name, owner):
                bodies.setdefault(known.group, []).append(place)
    parts = _apart(bodies, [known.unit in FRAMES for known in model.known])
    whole = [ChangedParameter(name, tuple(p), None) for name, p in parts if len(p) > 1]
    heavy = list(_heavier(model, bodies))
    # a mass that is another one has moments: alone it would be a point at the joint, which only
    # what carries payloads may have
    units = {p: model.known[p].unit for body in heavy for p in body.places}
    solid = [body for body in heavy if any(units[p] == MASSES[1] for p in body.places)]
    masses = {p for body in solid for p in body.places if units[p] == MASSES[0]}
    masses -= {*model.base.payload}
    alone = [one for one in single if not masses & {*one.places}]
    return [*alone, *whole, *heavy, *_wrong_file(model, single)]


def _apart(
    bodies: Mapping[str, Sequence[int]], frame: Sequence[bool]
) -> Iterator[tuple[str, Sequence[int]]]:
    """A body and its geometry by themselves: what changes one leaves the other, and together they
    would say the same twice (a centre of mass farther out, and a joint nearer)."""
    for name, places in bodies.items():
        own, placed = ([p for p in places if frame[p] == kind] for kind in (False, True))
        yield name, own or placed
        if own and placed:
            yield f"{name} (geometry)", placed


def _wrong_file(model: Calibrated, single: Sequence[ChangedParameter]) -> Iterator[WrongFile]:
    """All of them, if a fit finds them off by more than is allowed for."""
    places = tuple(p for one in single for p in one.places if p < len(model.base.linear))
    if len(places) > 1 and model.off > 1.0:
        yield WrongFile("machine file", places, None, times=model.off**0.5)


def _heavier(model: Calibrated, bodies: Mapping[str, Sequence[int]]) -> Iterator[HeavierBody]:
    """Masses and rotors, with the moments that go with them."""
    known, scale = model.known, model.scale
    rotors = {k.name: [p] for p, k in enumerate(known) if k.positive and "." not in k.name}
    for name, places in {**bodies, **rotors}.items():
        heavy = [p for p in places if known[p].unit in MASSES and scale[p] > 0]
        if any(known[p].positive for p in heavy):
            direction = np.array([known[p].nominal / scale[p] for p in heavy])
            yield HeavierBody(name, tuple(heavy), None, direction=direction)

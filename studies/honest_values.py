"""Numbers of an answer beside those of the truth: values, orders, delays, the share of the residual
that was removed."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

FAINT = 0.004
"""Share of torque RMS between the classes of size: below it silence about an effect of the library
is no miss."""
SIGMAS = 1.959964
"""Standard deviations on either side in a 95 % interval."""
CLOSABLE = 1.05
"""Least ratio of a residual to what it is without the effect where there is something to remove."""
SAME_ORDER = 0.01
"""Relative error of an order [1/m] that is the right one; of a turn only whole orders are there."""
LATE = ("drive_lag", "time_delay")
POSITIVE = re.compile(r"(\.m|\.J_(xx|yy|zz)|^J_r\[\d+\]|^[mJd]\[\d+\])$")
"""Names of parameters that no machine has at zero or below: masses, inertias, damping."""


def names_of(effect: Mapping[str, Any]) -> tuple[str, ...]:
    """Ids of an effect and of those that the data cannot tell from it."""
    rivals = effect.get("rivals") or []
    return (str(effect["id"]), *(r if isinstance(r, str) else str(r["id"]) for r in rivals))


def errors_of(
    hidden: Sequence[Mapping[str, Any]], effects: Sequence[Mapping[str, Any]]
) -> dict[str, float]:
    """Errors of the parameters of right names in standard deviations, by `id.parameter[axis]`."""
    errors: dict[str, float] = {}
    for h in hidden:
        for effect in effects:
            if effect["id"] not in h["accept"]:
                continue
            for name, row in h["parameters"].items():
                for axis, value in _values(row["value"], h["axes"]):
                    listed = [s for s in _estimates(effect, name, axis) if s[1] > 0]
                    if listed:
                        # of harmonics the one that is meant
                        near, sigma = min(listed, key=lambda s: abs(s[0] - value))
                        errors[f"{h['id']}.{name}[{axis}]"] = (near - value) / sigma
    return errors


def _values(value: Any, axes: Sequence[int]) -> list[tuple[int, float]]:
    """True values by axis; none where it is no number an axis."""
    listed = value if isinstance(value, list) else [value] * len(axes)
    pairs = zip(axes, listed, strict=False) if len(listed) == len(axes) else ()
    return [(axis, float(v)) for axis, v in pairs if isinstance(v, int | float)]


def _estimates(effect: Mapping[str, Any], name: str, axis: int) -> Iterator[tuple[float, float]]:
    """Values that an answer gives to a parameter on an axis, with their standard deviations: zero
    where it gives none."""
    alone = list(effect.get("axes") or []) in ([axis], [])
    for key, row in (effect.get("parameters") or {}).items():
        plain = key.partition("#")[0]
        if plain == f"{name}[{axis}]" or (plain == name and alone):
            low, high = (row.get("ci95") or [None, None])[:2]
            known = low is not None and high is not None
            yield float(row["value"]), (high - low) / (2 * SIGMAS) if known else 0.0


def checks_of(truth: Mapping[str, Any], answer: Mapping[str, Any]) -> dict[str, bool]:
    """Of a machine without a delay: `no delay`; of its cogging, where that can be seen, `order
    [axis]` and `harmonic k [axis]`: whether they were found."""
    said = "torque channel" in " ".join(answer.get("findings") or [])
    named = any(set(names_of(e)) & set(LATE) for e in answer["effects"])
    checks = {"no delay": not (said or named)}
    for h in truth["hidden"]:
        if "harmonics" not in h["parameters"]:
            continue
        heights = h["parameters"]["harmonics"]["value"]
        whole = sum(v * v for v in heights) ** 0.5
        entries = [e for e in answer["effects"] if set(names_of(e)) & set(h["accept"])]
        for axis, order in _values(h["parameters"]["order"]["value"], h["axes"]):
            said_orders = [s[0] for e in entries for s in _estimates(e, "order", axis)]
            turns = h["parameters"]["order"].get("unit", "1/rad") == "1/rad"
            for k, height in enumerate(heights, start=1):
                if h["observable_per_axis"][axis - 1] * height / whole >= FAINT:
                    reach = 0.5 if turns else SAME_ORDER * k * order
                    name = f"harmonic {k} [{axis}]" if k > 1 else f"order [{axis}]"
                    checks[name] = any(abs(o - k * order) < reach for o in said_orders)
    return checks


def closed_of(answer: Mapping[str, Any], twin: Mapping[str, Any] | None = None) -> float | None:
    """(before - after) / (before - without) on the test runs; without: of the twin, or else the
    non-repeatable part; None where the effect adds next to nothing."""
    before, after, noise = (_left(answer, key) for key in ("before", "after", "non_repeatable"))
    without = noise if twin is None else _left({**answer, "residual": twin}, "before")
    if before is None or after is None or without is None or before <= CLOSABLE * without:
        return None
    return (before - after) / (before - without)


def predicts(answer: Mapping[str, Any]) -> bool:
    """Whether what is named leaves less of the test runs than the model without it."""
    before, after = (_left(answer, key) for key in ("before", "after"))
    return before is not None and after is not None and after < before


def _left(answer: Mapping[str, Any], key: str) -> float | None:
    """RMS that is left of the test runs over the axes that have a name; None where unknown."""
    residual = answer.get("residual") or {}
    rows = residual.get("per_axis") or {}
    named = {str(axis) for e in answer["effects"] for axis in (e.get("axes") or rows)}
    values = [rows[axis].get(key) for axis in sorted(named & set(rows))]
    if residual.get("judged_on") != "held-out runs" or not values or None in values:
        return None
    return float(sum(value**2 for value in values) ** 0.5)

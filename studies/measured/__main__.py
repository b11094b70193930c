"""`python -m studies.measured DATA [--only emps,ur10e,tx40] [--json]`

DATA holds the sets, each as `git clone` leaves it (docs/measured-data.md names them).
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from studies.measured import others, ours
from studies.measured.sets import SETS, Measured
from studies.measured.sindy import sindy

SHOWN = ("m", "d", "F_c", "o")
"""Parameters of a single axis that are compared."""


def compared(measured: Measured) -> dict[str, Any]:
    """All methods on one set."""
    with tempfile.TemporaryDirectory() as folder:
        model = ours.identified(measured, Path(folder))
        named = ours.named(measured, Path(folder))
        carried = ours.payload(measured, Path(folder)) if measured.loaded else None
    plain, bic = others.usual(measured), others.by_bic(measured)

    def row(tool: str, predicted: Any, **more: Any) -> dict[str, Any]:
        each = {
            name: others.relative(measured, predicted, parts)
            for name, parts in (("fit", measured.fit), ("test", measured.test))
        }
        return {"tool": tool, **more, **each}

    single = measured.base == "axis"
    own = {n: model.result[f"{n}[1]"].estimate.data() for n in SHOWN} if single else {}
    names = ("m", "F_c", "d", "o")
    least = {n: float(v) for n, v in zip(names, plain.p, strict=True)} if single else {}
    listed = [
        row("flexhex identify", model, **own, delay=model.result.delay.data()),
        row("least squares", plain, **least),
        row("least squares, terms by BIC", bic, terms=[list(c) for c in bic.chosen]),
    ]
    if measured.coupled is not None:
        listed.append(row("least squares, wrist coupled", others.coupled(measured)))
    if single and (sparse := sindy(measured)) is not None:
        listed.append(sparse)
    return {
        "title": measured.title,
        "source": measured.source,
        "licence": measured.licence,
        "published": measured.published,
        "methods": listed,
        "diagnosis": named,
        "payload": carried and {**carried, "least_squares": others.payload_mass(measured)},
        "notes": list(model.result.notes),
    }


def shown(results: dict[str, Any]) -> str:
    """For the terminal."""
    lines = [results["title"], f"  diagnosis: {results['diagnosis']['verdict']}"]
    for effect in results["diagnosis"]["effects"]:
        rivals = f" or {', '.join(effect['rivals'])}" if effect["rivals"] else ""
        lines.append(f"    {effect['name']}{rivals} on axes {effect['axes']}")
    for method in results["methods"]:
        fit, test = (", ".join(f"{100 * v:.2f}" for v in method[name]) for name in ("fit", "test"))
        lines.append(f"  {method['tool']}: left of the torque [%]: fit {fit}; test {test}")
    if carried := results["payload"]:
        low, high = carried["ci95"]
        lines.append(
            f"  payload of {results['published']['payload']} kg: flexhex {carried['value']:.2f}"
            f" ({low:.2f} to {high:.2f}), least squares {carried['least_squares']:.2f}"
        )
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """0; 3 where a set is not there."""
    parser = argparse.ArgumentParser(prog="studies.measured", description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("--only", default=",".join(SETS))
    parser.add_argument("--json", action="store_true")
    given, results = parser.parse_args(arguments), {}
    for key in given.only.split(","):
        folder, read = SETS[key]
        if not (given.data / folder).is_dir():
            print(f"{given.data / folder}: not there; docs/measured-data.md", file=sys.stderr)
            return 3
        print(f"{key} ...", file=sys.stderr)
        results[key] = compared(read(given.data))
    print(json.dumps(results) if given.json else "\n\n".join(shown(f) for f in results.values()))
    return 0


if __name__ == "__main__":
    sys.exit(main())

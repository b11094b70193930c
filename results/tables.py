"""Tables of the guides, each from the `results` of its results file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from flexhex.diagnose.titles import readable, spaced, where
from results.shares import share

Results = Any
Rows = Iterable[Sequence[str]]
CASES = (
    ("feedback", "feedback only"),
    ("fixed", "fixed feedforward"),
    ("adaptive", "adaptive feedforward"),
    ("repeatability", "non-repeatable part of three passes"),
    ("paper-form", "adaptive, the paper's form of the filter"),
    ("exact-adaptive", "adaptive, exact plant"),
)


def markdown(head: Sequence[str], rows: Rows) -> str:
    """A table in Markdown; a bar in a cell becomes a slash, 5% becomes 5 %."""
    lines = [head, ["---"] * len(head), *rows]
    cells = [[spaced(cell).replace("|", "/") for cell in row] for row in lines]
    return "".join(f"| {' | '.join(row)} |\n" for row in cells)


def paper(results: Results) -> str:
    """RMS errors and torques beside [SH, Table I]."""
    head = ("RMS", "e [µrad]", "paper", "τ_FB [N m]", "paper")
    rows = [_case(title, results["cases"][n], results["paper"].get(n)) for n, title in CASES]
    alone, theirs = results["actuators"], results["paper_actuators"]
    rows += [_case(f"actuators alone: {t}", alone[n], theirs[n]) for n, t in CASES[:3]]
    return markdown(head, rows)


def _case(title: str, ours: Results, theirs: Sequence[float] | None) -> list[str]:
    def cells(e: float, tau: float) -> tuple[str, str]:
        return f"{e:.0f}" if e >= 100 else f"{e:.1f}", f"{tau:.4f}"

    e, tau = cells(ours["e"], ours["tau_fb"])
    their_e, their_tau = cells(*theirs[:2]) if theirs else ("", "")
    return [title, e, their_e, tau, their_tau]


def missing(results: Results) -> str:
    """The adaptive loop on the machine, with the model as it was and with the extended one."""
    run = results["experiments"]["missing"]
    residual, loops = run["diagnosis"]["residual"], run["shown"]["closed_loop"]["machine"]
    rows = []
    for title, key in (("as it was", "before"), ("extended", "after")):
        e, tau = loops[key]["e"], loops[key]["tau_fb"]
        both = (f"{1e3 * residual[name]:.2f}" for name in (key, "non_repeatable"))
        rows.append([title, f"{e:.1f}", f"{1e3 * tau:.2f}", *both])
    head = ("model", "e [µrad]", "τ_FB [mN m]", "residual of the held-out runs [mN m]")
    named = f"Named: {_names(run['diagnosis']['effects'])}.\n"
    return markdown((*head, "its non-repeatable part"), rows) + "\n" + named


def hidden(results: Results) -> str:
    """How the cases of the study ended, a column for each family of truth; rows with a case."""
    families, listed, before = results["families"], [], ""
    for each in zip(*families.values(), strict=True):
        if any(c["n"] for c in each):
            first = each[0]
            kind = first["kind"] if first["kind"] != before else ""
            listed.append([kind, first["ending"], first["wanted"], *map(_share, each)])
            before = first["kind"]
    return markdown(("hidden", "said", "wanted", *families), listed)


def _share(claim: Results) -> str:
    text = f"; {claim['text']}" if claim["text"] else ""
    return share(claim["hits"], claim["n"]) + text if claim["n"] else "–"


def cases(results: Results) -> str:
    """Every case of the study."""
    head = ("case", "hidden (axes)", "observable [% of torque RMS]", "verdict and names", "judged")
    listed = []
    for c in results["cases"]:
        truth = [f"{id} {_axes(a)}" for id, a in zip(c["hidden"], c["axes"], strict=False)]
        if not c["axes"]:
            truth = [f"changed: {name}" for name in c["hidden"]]
        named = [
            {"id": ids[0], "rivals": ids[1:], "axes": axes}
            for ids, axes in zip(c["named"], c["named_axes"], strict=True)
        ]
        said = ": ".join(filter(None, (c["verdict"], _names(named))))
        seen = ", ".join(f"{100 * x:.2f}" for x in c["observable"])
        name = f"{c['family']} {c['seed']}, {c['machine']}"
        listed.append((name, "; ".join(truth) or "nothing", seen, said, c["outcome"]))
    return markdown(head, listed)


def sensitivity(results: Results) -> str:
    """What becomes of the cases where a criterion is halved or doubled."""
    known, usual = results["variations"], results["variations"]["as it is"]
    of = f"of {usual['n']} cases: well / wrong / changed"
    rows = [["as they are", "", f"{usual['good']} / {usual['wrong']}", ""]]
    for name, value in results["values"].items():
        each = [known.get(f"{name} x {factor:g}") for factor in (0.5, 2.0)]
        if any(each):
            rows.append([f"`{name}`", f"{value:g}", *map(_variation, each)])
    return markdown(("criterion", "value", f"halved, {of}", "doubled"), rows)


def _variation(row: Results) -> str:
    return f"{row['good']} / {row['wrong']} / {len(row['moved'])}" if row else ""


def machines(lines: Results) -> str:
    """Machines of the showcase, failures too."""
    head = (
        "machine",
        "hidden (axes, N m)",
        "verdict and names",
        "judged",
        "residual of the held-out runs [mN m]: before → after (non-repeatable part)",
        "e on the machine [µrad]",
    )
    return markdown(head, [_machine(line) for line in lines])


def _machine(line: Results) -> list[str]:
    hidden = "; ".join(f"{h['kind']} {_axes(h['axes'])} {h['size']:.3f}" for h in line["hidden"])
    name = str(line["number"]) if line["number"] else "default"
    if "error" in line:
        return [name, hidden, " ".join(line["error"].split())[:300], "failed", "", ""]
    diagnosis, shown = line["diagnosis"], line["shown"]
    names = [_names(diagnosis["effects"])] if diagnosis["effects"] else []
    names += [f"changed {c['parameter']}" for c in diagnosis["changed"]]
    names += [f"withdrawn {id}" for id in shown["withdrawn"]]
    before, after, rest = (
        1e3 * diagnosis["residual"][k] for k in ("before", "after", "non_repeatable")
    )
    loop = shown["closed_loop"]["machine"]
    return [
        name,
        hidden,
        ": ".join(filter(None, (diagnosis["verdict"], "; ".join(names)))),
        line["judged"],
        f"{before:.2f} → {after:.2f} ({rest:.2f})",
        f"{loop['before']['e']:.1f} → {loop['after']['e']:.1f}",
    ]


def _names(effects: Sequence[Results]) -> str:
    return "; ".join(
        f"{e['id']} {_axes(e['axes'])}" + (f" (or {', '.join(e['rivals'])})" if e["rivals"] else "")
        for e in effects
    )


def _axes(axes: Sequence[int]) -> str:
    return "all" if len(axes) in (0, 6) else ",".join(map(str, axes))


def schunk(results: Results) -> str:
    """Effects of the measured arm and its residual, axis by axis."""
    rows = []
    for axis, residual in results["residual"]["per_axis"].items():
        own = [e for e in results["effects"] if int(axis) in e["axes"]]
        names = "; ".join(" or ".join((e["id"], *e["rivals"])) for e in own) or "not named"
        values = "; ".join(text for e in own for text in _values(e, axis))
        rows.append([axis, names, values, *(f"{residual[key]:.2f}" for key in ("before", "after"))])
    head = ("axis", "named", "parameters (95 %)", "residual before [N m]", "after [N m]")
    return markdown(head, rows)


def _values(effect: Results, axis: str) -> list[str]:
    """Parameters of an effect on one of its axes."""
    return [
        f"{name} = {v['value']:.4g} ({v['ci95'][0]:.4g} to {v['ci95'][1]:.4g}) {v['unit']}"
        for name, v in effect["parameters"].items()
        if len(effect["axes"]) == 1 or f"[{axis}]" in name
    ]


def measured(results: Results) -> str:
    """What each method leaves of the torque of the measured machines, axis by axis."""
    rows = []
    for one in results.values():
        for method in one["methods"]:
            each = (", ".join(f"{100 * v:.1f}" for v in method[part]) for part in ("fit", "test"))
            rows.append([one["title"], method["tool"], *each])
    return markdown(("machine", "method", "left, fit [%]", "left, test [%]"), rows)


def emps(results: Results) -> str:
    """Parameters of EMPS by each method beside those in print."""
    published, methods = results["emps"]["published"], results["emps"]["methods"]
    shown = [m for m in methods if "m" in m]
    rows = []
    for name, unit in (("m", "kg"), ("d", "N s/m"), ("F_c", "N"), ("o", "N")):
        cells = []
        for method in shown:
            value = method[name]
            if isinstance(value, dict):
                low, high = value["ci95"]
                cells.append(f"{value['value']:.1f} ({low:.1f} to {high:.1f})")
            else:
                cells.append(f"{value + 0.0:.1f}")
        rows.append([f"{name} [{unit}]", f"{published[name]:.1f}", *cells])
    return markdown(("", "published", *(m["tool"] for m in shown)), rows)


def measured_names(results: Results) -> str:
    """What the diagnosis says of each measured machine."""
    rows = []
    for one in results.values():
        said = one["diagnosis"]
        names = "; ".join(
            " or ".join((e["name"], *e["rivals"])) + f", {where(e['axes'], short=True)}"
            for e in said["effects"]
        )
        sentences = (readable(text) for text in (names, "; ".join(said["notes"])))
        rows.append([one["title"], said["verdict"], *sentences])
    return markdown(("machine", "verdict", "named", "notes"), rows)


def measured_payload(results: Results) -> str:
    """The mass that came between runs of the UR10e."""
    carried, true = results["ur10e"]["payload"], results["ur10e"]["published"]["payload"]
    low, high = carried["ci95"]
    own = f"{carried['value']:.2f} ({low:.2f} to {high:.2f})"
    return markdown(
        ("weighed [kg]", "flexhex [kg]", "least squares [kg]"),
        [[f"{true:.3f}", own, f"{carried['least_squares']:.2f}"]],
    )


def provenance(files: Results) -> str:
    """How each results file was made."""
    rows = []
    for name, m in files.items():
        computer = m["computer"]
        place = f"{computer['cpu']}, {computer['cores']} cores, load {computer['load']}"
        took = f"{m['minutes']:g} min"
        if "processor_minutes" in m:
            took += f", {m['processor_minutes']:g} of a core"
        commit = m["commit"][:7] + (" with changes" if m["dirty"] else "")
        link = f"[{name}.json]({name}.json)"
        rows.append(
            [link, f"`{m['command']}`", commit, m["date"][:10], took, place, computer["compiler"]]
        )
    head = ("file", "command", "commit", "date", "took", "computer", "compiler")
    return markdown(head, rows)

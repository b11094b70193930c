"""Tables of times and of the drives, each from the `results` of its results file."""

from __future__ import annotations

from results.tables import Results, markdown


def speed(results: Results) -> str:
    """Ours beside its rivals."""
    head = ("what", "median", "required", "stretch", "beside it", "ratio")
    rows = []
    for row in results["rows"]:
        first, *rivals = row["timings"]
        unit = _factor if row["faster"] else _micro
        limits = [unit(x) if x else "" for x in (row["required"], row["stretch"])]
        met = ["", " no", " yes"]
        marks = [met[_mark(row[k])] for k in ("met_required", "met_stretch")]
        own = [row["what"], unit(first["median"])]
        own += [limit + mark for limit, mark in zip(limits, marks, strict=True)]
        for k, rival in enumerate(rivals):
            beside = [
                f"{rival['name']} {unit(rival['median'])}",
                f"{row['ratios'][rival['name']]:.3g}",
            ]
            rows.append([*(own if k == 0 else [""] * 4), *beside])
        if not rivals:
            rows.append([*own, "", ""])
    return markdown(head, rows)


def _mark(met: bool | None) -> int:
    return 0 if met is None else 1 + met


def _micro(ns: float) -> str:
    unit, size = next((u, s) for u, s in (("s", 1e9), ("ms", 1e6), ("µs", 0.0)) if ns >= s)
    return f"{ns / (size or 1e3):.3g} {unit}"


def _factor(value: float) -> str:
    return f"{value:.3g} ×"


def growth(results: Results) -> str:
    """Time of K over its number of parameters."""
    timings = results["growth"]["parameters"]
    rows = [[t["name"], f"{t['median'] / 1e3:.3g}", f"{t['median'] / int(t['name']) ** 2:.2f}"]
            for t in timings]  # fmt: skip
    return markdown(("parameters of K", "median [µs]", "ns for a square of a parameter"), rows)


def loops(results: Results) -> str:
    """Loops side by side and plain C, as multiples of one on one core; where C was measured, too:
    loops of before were measured with what opens them."""
    parts, head = results["growth"], ("side by side", "for one on one core, by the clock")
    plain = parts.get("cores", {})
    one = next(iter(parts["loops"].values()))[0]
    rows = [[name, f"{clock / one:.2f}"] for name, (clock, _) in parts["loops"].items() if plain]
    rows += [[f"plain C on 2 cores: {kind}", f"{gain:.2f}"] for kind, gain in plain.items()]
    return markdown(head, rows)


def profile(results: Results) -> str:
    """Share of each FMU in the time of the loop."""
    parts = results["profile"]
    total = sum(spent for spent, _ in parts.values())
    rows = [[name, f"{100 * spent / total:.0f} %"] for name, (spent, _) in parts.items()]
    return markdown(("FMU", "share of the loop's time"), rows)


def operations(results: Results) -> str:
    """Operations of the generated functions that run at every tick."""
    rows = [
        [block, name, str(count)]
        for block, functions in results["operations"].items()
        for name, count in functions.items()
    ]
    return markdown(("FMU", "generated function", "operations"), rows)


def quantisation(results: Results) -> str:
    """Tracking error with the drives' steps: the model, the machine."""
    names = ("model", "machine")
    head = ["steps of the drive", *(f"{name}: RMS, largest, change [µrad]" for name in names)]
    rows = []
    for variants in zip(*results["systems"].values(), strict=True):
        cells = [f"{v['rms']:.3f}, {v['max']:.2f}, {v['change']:.4f}" for v in variants]
        rows.append([variants[0]["title"], *cells])
    return markdown(head, rows)


def drive_errors(results: Results) -> str:
    """Tracking error of the adaptive loop over emulated drives, and of the simulation."""
    runs = results["tracking error [urad]"].items()
    rows = [[name, f"{rms:.1f}", f"{largest:.1f}"] for name, (rms, largest) in runs]
    return markdown(("run", "e RMS [µrad]", "largest [µrad]"), rows)


def drive_times(results: Results) -> str:
    """Quantiles of the parts of a cycle, both passes by the clock beside cyclictest."""
    passes = {n: s for n, s in results["summary"].items() if n.startswith("clock")}
    parts = ("wake_up_us", "round_trip_us", "compute_us", "after_reply_us")
    quantiles = ("p50", "p99", "max")
    rows = [
        [
            part.removesuffix("_us").replace("_", " "),
            name,
            *(f"{s[part][q]:.1f}" for q in quantiles),
        ]
        for part in parts
        for name, s in passes.items()
    ]
    own = results["cyclictest [us]"]
    if own:
        rows.append(["cyclictest", "", *(f"{own[q]:.1f}" for q in quantiles)])
    return markdown(("part of a cycle of 250 µs", "run", *(f"{q} [µs]" for q in quantiles)), rows)

"""documentation/index.html of an FMU: what it does, when, its variables, its equations."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Iterator, Sequence

from flexhex.fmugen.sources import Operations, variables
from flexhex.fmugen.units import display_unit
from flexhex.fmus.common.interface import Interface, Variable, written

_STYLE = (
    "body{font:15px/1.45 sans-serif;margin:2em auto;max-width:62em;padding:0 1em;color:#222}"
    "td,th{border:1px solid #ccc;padding:2px 8px;text-align:left;vertical-align:top}"
    "table{border-collapse:collapse;margin:1em 0}code,pre{background:#f3f3f3}"
    "pre{padding:.6em;overflow-x:auto}img{max-width:100%}"
)
BUILD = "cc -std=c99 -O2 -ffp-contract=off -shared -fPIC sources/*.c -lm -o {name}.so"
"""The one compiler call that builds an FMU from its own sources."""


def page(
    interface: Interface,
    operations: Sequence[Operations],
    block: str,
    base_step: float,
    readme: str,
) -> str:
    """The page; readme: that of the FMU's folder (Markdown), empty without one."""
    name = html.escape(interface.name)
    parts = [
        f"<h1>{name}</h1><p>{html.escape(interface.description)}.</p>",
        f"<p><img src='../model.png' alt='{name} with its inputs and outputs'></p>",
        _timing(interface, base_step),
        f"<h2>Variables</h2>{_table(interface)}",
        f"<h2>Equations</h2>{_equations(operations, block)}",
        _importing(interface),
        f"<h2>About this FMU</h2>{''.join(markdown(readme))}" if readme else "",
    ]
    return (
        f"<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'><title>{name}</title>"
        f"<style>{_STYLE}</style></head><body>\n" + "\n".join(parts) + "\n</body></html>\n"
    )


def _timing(interface: Interface, base_step: float) -> str:
    return (
        "<h2>Timing</h2><p>Time counts in base steps of"
        f" {base_step * 1e3:g} ms; communication steps are whole numbers of them. Inputs are read"
        f" at k Ts, k from 1 on, with Ts = {interface.Ts * 1e3:g} ms; what follows from them"
        " appears at (k+1) Ts, however the importer slices its steps. No output depends on an"
        " input of the same instant.</p>"
    )


def _number(value: float) -> str:
    return "" if math.isinf(value) else f"{value:.9g}"


def _table(interface: Interface) -> str:
    heads = ("variable", "is", "unit or type", "shown in", "from", "to", "start", "meaning")
    rows = [_row(v) for v in variables(interface)]
    lines = (
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return (
        "<table><tr>" + "".join(f"<th>{h}</th>" for h in heads) + "</tr>\n"
        "" + "\n".join(lines) + "</table>"
    )


def _row(v: Variable) -> tuple[str, ...]:
    alike = len(set(v.starts)) == 1
    value = _number(v.starts[0]) if v.type == "Real" else written(v.type, v.starts[0])
    start = "" if v.causality == "output" else value if alike else "see description"
    kind = f"{v.variability} parameter" if v.causality == "parameter" else v.causality
    unit = "various" if len(set(v.units)) > 1 else v.units[0] if v.units else v.unit
    first, last = v.scalar_names[0], v.scalar_names[-1]
    name = f"{first} ... {last}, {v.size} in all" if v.elements else v.name
    name = f"{v.name}[1..{v.size}]" if v.size and not v.elements else name
    shown = display_unit(v, unit) if unit != "various" else ""
    least = _number(v.lows[0]) if len(set(v.lows)) == 1 else "see description"
    limits = ("", "") if v.type == "Boolean" else (least, _number(v.max))
    codes = "; ".join(f"{k} {item.name}: {item.description}" for k, item in enumerate(v.items))
    text = f"{v.description}: {codes}" if codes else v.description
    unit = unit if v.type == "Real" else v.type
    return (name, kind, unit, shown, *limits, start, text)


def _equations(operations: Sequence[Operations], block: str) -> str:
    if not operations:
        return f"<p>None: <code>fmus/{block}/step.c</code> does without.</p>"
    rows = "".join(
        f"<tr><td><code>{html.escape(o.function)}({', '.join(o.ins)})</code></td>"
        f"<td>{', '.join(o.outs)}</td><td>{o.count}</td></tr>"
        for o in operations
    )
    return (
        f"<p>From <code>fmus/{block}/equations.py</code> (CasADi), as straight-line C in"
        f" <code>sources/</code>; <code>fmus/{block}/step.c</code> decides when each is used.</p>"
        f"<table><tr><th>function</th><th>gives</th><th>operations</th></tr>{rows}</table>"
    )


def _importing(interface: Interface) -> str:
    build = html.escape(BUILD.format(name=interface.name))
    return (
        "<h2>Faults and sources</h2><p>A value that is no number or out of range, and a call at"
        " the wrong time, is refused (fmi2Error) and changes nothing; the output <code>fault</code>"
        " is 1 from then on until fmi2Reset. 2 and above are this FMU's own, see below.</p>"
        f"<p>The sources build with one call:</p><pre>{build}</pre>"
        "<p>or with <code>cmake -S sources -B build &amp;&amp; cmake --build build</code>. With"
        " <code>-DFLEXHEX_STATIC</code> all functions wear the FMU's name, so that several FMUs"
        " link into one program.</p>"
        "<p>Licences of all that is inside: <a href='licenses/license.txt'>license.txt</a>.</p>"
    )


def markdown(text: str) -> Iterator[str]:
    """HTML of the Markdown that READMEs here use: headings, paragraphs, tables, code, bold.

    Pictures are left out: they are not in the FMU.
    """
    for block in re.split(r"\n\s*\n", text.strip()):
        lines = block.splitlines()
        if lines[0].startswith("!["):
            continue
        if lines[0].startswith("#"):
            head = lines.pop(0)
            yield f"<h3>{_inline(head.lstrip('# '))}</h3>\n"
        if not lines:
            continue
        if lines[0].startswith("|"):
            cells = [
                [c.strip().replace("\\|", "|") for c in re.split(r"(?<!\\)\|", line.strip()[1:-1])]
                for line in lines
            ]
            yield (
                "<table>"
                + "".join(
                    "<tr>" + "".join(f"<td>{_inline(c)}</td>" for c in row) + "</tr>"
                    for row in cells
                    if not all(set(c) <= set("-: ") and c for c in row)
                )
                + "</table>\n"
            )
        elif lines[0].startswith(("- ", "* ")):
            items = re.split(r"\n[-*] ", "\n" + "\n".join(lines))[1:]
            yield "<ul>" + "".join(f"<li>{_inline(item)}</li>" for item in items) + "</ul>\n"
        else:
            yield f"<p>{_inline(' '.join(lines))}</p>\n"


def _inline(text: str) -> str:
    safe = html.escape(text, quote=False)
    safe = re.sub(r"`([^`]+)`", r"<code>\1</code>", safe)
    safe = re.sub(r"\*\*([^*]+)\*\*", r"<b>\1</b>", safe)
    return re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", safe)

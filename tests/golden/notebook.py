"""A notebook whose code cells run in one namespace, by plain Python, and show what Jupyter would.

Outputs are kept as Jupyter keeps them, without counts of execution, times and paths.
"""

from __future__ import annotations

import ast
import base64
import io
import json
import re
from contextlib import redirect_stdout
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

Output = dict[str, Any]
Cell = dict[str, Any]
DPI = 85
"""Of the figures."""
NUMBER = re.compile(r"(?<![\w.\]])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
RTOL, STEPS = 0.05, 2.0
"""Numbers may differ by so much of their size, or by so many steps of their last printed digit:
other processors sum in another order, and a fit ends a little elsewhere."""
STUDY = re.compile(r" ?Confidence \d+ %, as .*? were right \(Laplace's rule\)\.")
"""What comes from the study of the diagnosis, not from these runs."""


def read(path: Path) -> dict[str, Any]:
    """A notebook as data."""
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return data


def write(path: Path, notebook: dict[str, Any]) -> None:
    """As Jupyter writes it."""
    path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def code_cells(notebook: dict[str, Any]) -> list[Cell]:
    """Its cells with code."""
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def run(cell: Cell, names: dict[str, Any]) -> list[Output]:
    """Outputs of a cell that runs in a namespace: what it prints, the value of its last line,
    figures that are open at its end."""
    import matplotlib.pyplot as plt

    tree, value, printed = ast.parse("".join(cell["source"])), None, io.StringIO()
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    with redirect_stdout(printed):
        exec(compile(tree, cell["id"], "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), cell["id"], "eval"), names)
    outputs: list[Output] = []
    if printed.getvalue():
        outputs.append(
            {"name": "stdout", "output_type": "stream", "text": _lines(printed.getvalue())}
        )
    if value is not None:
        data = {"text/plain": _lines(repr(value))}
        if hasattr(value, "_repr_html_"):
            data["text/html"] = _lines(value._repr_html_())
        outputs.append(
            {"data": data, "execution_count": None, "metadata": {}, "output_type": "execute_result"}
        )
    for number in plt.get_fignums():
        picture = io.BytesIO()
        plt.figure(number).savefig(picture, dpi=DPI, metadata={"Software": None})
        data = {"image/png": base64.b64encode(picture.getvalue()).decode() + "\n"}
        outputs.append({"data": data, "metadata": {}, "output_type": "display_data"})
    plt.close("all")
    return outputs


def texts(outputs: list[Output]) -> list[str]:
    """Words of outputs, one text for each; a figure is known by its kind alone."""
    said = []
    for output in outputs:
        data = output.get("data", {"text/plain": output.get("text", "")})
        said += [f"{kind}: {_plain(kind, data[kind])}" for kind in sorted(data)]
    return said


def difference(text: str, other: str) -> str:
    """How two texts differ in words, or in numbers by more than allowed; nothing if they do not."""
    text, other = (" ".join(STUDY.sub("", one).split()) for one in (text, other))
    words, others = NUMBER.split(text), NUMBER.split(other)
    if [word.strip() for word in words] != [word.strip() for word in others]:
        pair = next((p for p in zip(words, others, strict=False) if p[0] != p[1]), ("", "more"))
        return f"{pair[0]!r} instead of {pair[1]!r}"
    for a, b in zip(NUMBER.findall(text), NUMBER.findall(other), strict=True):
        most = max(STEPS * max(_digit(a), _digit(b)), RTOL * abs(float(b)))
        if abs(float(a) - float(b)) > most * (1 + 1e-9):
            return f"{a} instead of {b}"
    return ""


def _digit(number: str) -> float:
    """A step of its last digit; none of a whole number, which counts something."""
    size, _, power = number.partition("e")
    return 10.0 ** (int(power or 0) - len(size.partition(".")[2])) if "." in size else 0.0


def _plain(kind: str, data: str | list[str]) -> str:
    """Text without tags; of a figure nothing."""
    if kind == "image/png":
        return ""
    whole = "".join(data)
    if kind == "text/plain":
        return whole
    found: list[str] = []
    parser = HTMLParser()
    parser.handle_data = found.append  # type: ignore[method-assign]
    parser.feed(whole)
    return " ".join(found)


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)

"""What a study keeps and shows, with invented figures: nothing is run here.

Interrupted, failed and torn runs; table, box plots, page, JSON.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.output.tables import texts
from flexhex.study.draws import StudyPlan
from flexhex.study.store import Scored, Store, file_name
from flexhex.study.tasks import CASES, Task, carry_out
from flexhex.study.view import COLUMNS, box, remarks, result_json, rows, summaries, write_result


def invented(count: int = 6) -> list[Task]:
    """Tasks that nothing runs."""
    ssp = Path("hexapod.ssp")
    pairs = [(case, k) for k in range(1, count // 2 + 1) for case in CASES]
    return [Task(case, k, ssp, 1.0, {}, {"payload": k / 10}, f"{case}{k}") for case, k in pairs]


def scored(task: Task) -> Scored:
    """Figures by number: fixed 10, 20, ... urad, adaptive half of them."""
    e = task.number * 1e-5 * (1.0 if task.case == "fixed" else 0.5)
    return Scored(task.key, task.case, task.number, e, e * 1e3, 0, task.drawn)


class Counting:
    """A pool that counts; dies of Ctrl-C before task number `dies`, `fails` are refused."""

    def __init__(self, dies: int = 99, fails: Sequence[str] = ()) -> None:
        self.done: list[str] = []
        self.dies, self.fails = dies, fails

    def __call__(self, listed: Sequence[Task]) -> Iterator[tuple[Task, Scored | str]]:
        for task in listed:
            if len(self.done) == self.dies:
                raise KeyboardInterrupt
            self.done.append(task.key)
            yield task, "end stop" if task.key in self.fails else scored(task)


def test_study_goes_on_after_ctrl_c_and_runs_nothing_twice(tmp_path: Path) -> None:
    listed, path = invented(), tmp_path / "new" / "s.jsonl"
    broken, rest = Counting(dies=3), Counting()
    with pytest.raises(KeyboardInterrupt):
        carry_out(StudyPlan(3), listed, Store(path), broken)
    seen: list[tuple[int, int]] = []
    result = carry_out(StudyPlan(3), listed, Store(path), rest, lambda *at: seen.append(at))
    assert broken.done + rest.done == [t.key for t in listed]
    assert (result.kept, len(result.scored)) == (3, 6)
    assert seen == [(3, 6), (4, 6), (5, 6), (6, 6)]
    last = Counting()
    assert carry_out(StudyPlan(3), listed, Store(path), last).scored == result.scored
    assert last.done == []


def test_failed_run_is_reported_and_tried_again(tmp_path: Path) -> None:
    listed, path = invented(), tmp_path / "s.jsonl"
    result = carry_out(StudyPlan(3), listed, Store(path), Counting(fails=["adaptive2"]))
    assert list(result.failed.values()) == ["adaptive, run 2: end stop"]
    assert [s.number for s in result.of("adaptive")] == [1, 3]
    assert "failed: adaptive, run 2: end stop" in remarks(result)
    again = Counting()
    assert not carry_out(StudyPlan(3), listed, Store(path), again).failed
    assert again.done == ["adaptive2"]


def test_torn_last_line_is_cut_off_at_any_byte(tmp_path: Path) -> None:
    path = tmp_path / "s.jsonl"
    carry_out(StudyPlan(1), invented(2), Store(path), Counting())
    whole = path.read_bytes()
    second = whole.index(b"\n") + 1
    for cut in range(second, len(whole)):
        path.write_bytes(whole[:cut])
        store = Store(path)
        assert list(store.done) == ["fixed1"]
        store.add(scored(invented(2)[1]))
        assert path.read_bytes() == whole
    path.write_bytes(whole[:5])
    assert not Store(path).done


@pytest.mark.parametrize("text", ["a,b\n1,2\n", '{"key": 1}\n', "notes", '{"a": NaN}\n'])
def test_file_of_something_else_is_refused_and_left_alone(text: str, tmp_path: Path) -> None:
    path = tmp_path / "s.jsonl"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(LogError, match=r"s\.jsonl:1: no run of flexhex study"):
        Store(path)
    assert path.read_text(encoding="utf-8") == text


def test_name_cannot_lead_elsewhere() -> None:
    assert file_name("payload-1kg", "html") == "payload-1kg.html"
    for name in ("../x", "a/b", "", ".x"):
        with pytest.raises(UsageError, match="--name"):
            file_name(name, "jsonl")


def test_table_shows_median_and_limits(tmp_path: Path) -> None:
    """Errors 10, 20, ... 210 urad: median 110, 5 % 20, 95 % 200; adaptive half of that."""
    result = carry_out(StudyPlan(21), invented(42), Store(tmp_path / "s.jsonl"), Counting())
    _, (fixed, adaptive) = texts(COLUMNS, rows(result))
    assert fixed[1:5] == ["21", "110.0", "20.0", "200.0"]
    assert adaptive[2:] == ["55.0", "10.0", "100.0", "0.0550", "0.0100", "0.1000"]
    assert "in 21 of 21 runs, the median of adaptive / fixed is 0.50" in remarks(result)[1]
    assert [s.faulty for s in summaries(result)] == [0, 0]


def test_box_ends_at_its_percentiles() -> None:
    whiskers, body, median, dots = box([float(v) for v in range(101)], 1.0, "x", "#000")
    numbers = [v for v in whiskers["y"] if v is not None]  # type: ignore[attr-defined]
    assert (min(numbers), max(numbers)) == (5, 95)
    assert set(body["y"]) == {25, 75}  # type: ignore[call-overload]
    assert median["y"] == [50, 50]
    assert len(dots["y"]) == 101  # type: ignore[arg-type]


def test_page_and_json_hold_every_run(tmp_path: Path) -> None:
    result = carry_out(StudyPlan(3), invented(), Store(tmp_path / "s.jsonl"), Counting())
    text = write_result(result, tmp_path / "s.html").read_text(encoding="utf-8")
    places = re.findall(r'class="plot" id="([\w-]+)"', text)
    assert places == ["error", "torque", "over-payload", "over-age"]
    drawn = json.loads(re.search(r"^const figures = (.*);$", text, re.M)[1])  # type: ignore[index]
    assert drawn["over-payload"]["data"][0]["x"] == [0.1, 0.2, 0.3]
    assert not re.search(r"<(script|img|iframe)[^>]*\ssrc=|<link", text)
    data = json.loads(result_json(result, tmp_path / "s.jsonl", tmp_path / "s.html"))
    assert data["cases"]["adaptive"]["e"][2] == pytest.approx(1e-5)
    assert len(data["runs"]) == 6

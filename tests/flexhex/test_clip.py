"""The moving pictures of the report."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexhex.diagnosis.result.pictured import Strip
from flexhex.experiments.payload import Payload
from flexhex.fmus.common.machine_file import load_machine
from flexhex.output.page import page_html
from flexhex.run.clip import BEFORE, FARTHEST, LEARNING, clips, clips_json
from flexhex.run.report import text_of
from flexhex.ssp.result import Group, Result
from flexhex.ssp.results import save
from flexhex.tracking import SETTLE
from tests.conftest import MACHINE_FILE
from tests.flexhex.browser import Browser
from tests.flexhex.test_view import LARGEST, numbers, run_of

CHOOSE = """new Promise(done => {
  const inside = document.querySelector(".clips iframe"), before = inside.contentDocument;
  document.querySelectorAll(".clips .tools button")[%d].click();
  const look = () => inside.contentDocument !== before
    && inside.contentDocument?.documentElement?.dataset.ready === "yes"
    ? done() : setTimeout(look, 50);
  look();
})"""
SECONDS, KILOGRAMS = 9.0, 0.5


def paper_run(larger: float = 1.0, machine: Any = None, **experiments: Any) -> Any:
    """Two outcomes; the errors of feedback only are `larger` times those of `run_of`."""
    results = {name: run_of(seconds=SECONDS) for name in ("feedback", "adaptive")}
    results["feedback"]["feedback.e"][:] *= larger
    outcomes = {
        name: SimpleNamespace(case=SimpleNamespace(name=name, title=f"{name} title"), result=result)
        for name, result in results.items()
    }
    builder = SimpleNamespace(machine=machine or load_machine(MACHINE_FILE))
    table = SimpleNamespace(of=outcomes.__getitem__)
    return SimpleNamespace(
        builder=builder, table=table, adaptive=outcomes["adaptive"], experiments=experiments
    )


def payload() -> Payload:
    """A payload from 3 s of the trajectory on, of which the estimate has 0.4 kg 1 s later."""
    t = 0.03 * np.arange(round(SECONDS / 0.03) + 1)
    true = np.where(t >= SETTLE + 3, KILOGRAMS, 0.0)
    kept = t >= SETTLE
    results = []
    for _ in range(2):
        result = run_of(seconds=SECONDS)
        base = result.group("plant.theta")
        carried = np.where(base.time >= SETTLE + 3, KILOGRAMS, 0.0)
        signals = {**base.signals, "reference.payload": carried}
        groups = {"0.25ms": Group(base.period, base.base, signals, base.units)}
        groups["30ms"] = Group(120, base.base, {"K.p": np.zeros((len(t), 3))})
        results.append(Result(groups, duration=SECONDS))
    estimate = np.where(t >= SETTLE + 4, 0.4, 0.0)[kept]
    empty = np.zeros(0)
    return Payload(
        empty, empty, empty, t[kept], estimate, empty, true[kept],
        (0.0, 3.0), (0.0, KILOGRAMS), tuple(results),
    )  # fmt: skip


def missing(folder: Path) -> Any:
    """A diagnosis with a held-out run of which the first model leaves 0.3 N m, the second 0.1."""
    base = run_of(seconds=7.0).group("plant.theta")
    signals = {name: base.signals[name] for name in ("plant.theta", "plant.tau_meas")}
    units = {"plant.theta": "rad", "plant.tau_meas": "N m"}
    log = Result({"0.25ms": Group(base.period, base.base, signals, units)}, duration=7.0)
    path = save(log, folder / "log.h5")
    t = 0.01 * np.arange(700)
    one = Strip(str(path), True, 1, "N m", t, np.cos(t), np.cos(t) - 0.3, np.cos(t) - 0.1)
    six = [one] * 6
    return SimpleNamespace(diagnosis=SimpleNamespace(effects=["friction"], strips=six))


@pytest.mark.parametrize("larger", [1.0, 40.0])
def test_clip_shows_both_runs_with_the_error_times_1000(larger: float) -> None:
    """It begins where the larger error is largest, so that the first picture shows it."""
    (clip,) = clips(paper_run(larger))
    data = clip.data
    assert [run["name"] for run in data["runs"]] == ["feedback title", "adaptive title"]
    assert (data["begin"], data["end"], data["begins"]["ghost"]) == (2.0, 6.0, "beside")
    assert data["begins"]["factor"] == 1000
    assert "drawn 1000 times" in clip.text
    result = paper_run(larger).table.of("feedback").result
    error = np.abs(result["feedback.e"]).max(axis=1)
    at = np.searchsorted(result.time("feedback.e"), data["begins"]["t"])
    assert error[at] == pytest.approx(larger * 20e-6, rel=1e-3)


@pytest.mark.parametrize("larger", [1.0, 40.0])
def test_clip_of_the_payload_has_an_error_that_is_seen(larger: float) -> None:
    """20 urad is magnified by 1000, the most; 800 urad by less, so that it stays below FARTHEST."""
    built = payload()
    for result in built.results:
        result["feedback.e"][:] *= larger
    listed = clips(paper_run(payload=built))[1]
    factor = listed.data["begins"]["factor"]
    most = max(np.abs(numbers(run["frames"]["e"])).max() for run in listed.data["runs"])
    assert factor * most <= FARTHEST
    assert factor == 1000 or factor * most * 10**0.25 > FARTHEST
    assert {1.0: "drawn 1000 times", 40.0: "drawn 180 times"}[larger] in listed.text


def test_clip_of_the_payload_carries_it_and_shows_what_the_model_takes_for_it() -> None:
    listed = clips(paper_run(payload=payload()))[1]
    data = listed.data
    begin = SETTLE + 3 - BEFORE
    assert (data["begin"], data["end"]) == (begin, min(SETTLE + 3 + LEARNING, SECONDS))
    assert data["begins"]["plots"] == ["feedback.e", "mass"]
    for run, learnt in zip(data["runs"], (0.0, 0.4), strict=True):
        frames = run["frames"]
        times = frames["t0"] + frames["step"] * np.arange(frames["count"])
        carried = np.where(times >= SETTLE + 3 - 1e-9, KILOGRAMS, 0.0)
        assert np.allclose(numbers(frames["payload"]), carried)
        mass = next(signal for signal in run["signals"] if signal["name"] == "mass")
        assert mass["columns"] == [".true", ".model"]
        true, model = (numbers(line["values"]) for line in mass["lines"])
        assert (true.min(), true.max()) == (0.0, KILOGRAMS)
        assert model.max() == np.float32(learnt)
        line = mass["lines"][0]
        rises = line["t0"] + line["step"] * int(np.argmax(true > 0))
        assert rises == pytest.approx(SETTLE + 3, abs=2 * line["step"])
    assert "0.5 kg is bolted on at 5 s" in listed.text


def test_clip_of_the_residual_has_both_models(tmp_path: Path) -> None:
    listed = clips(paper_run(missing=missing(tmp_path)))[1]
    assert "held-out" in listed.text
    left = [numbers(run["frames"]["residual"]) for run in listed.data["runs"]]
    assert [run["name"] for run in listed.data["runs"]] == ["original model", "extended model"]
    assert np.allclose(left[0], 0.3, atol=1e-6)
    assert np.allclose(left[1], 0.1, atol=1e-6)


def test_all_clips_share_one_page(tmp_path: Path) -> None:
    """The libraries stand there once, so the report stays small."""
    listed = clips(paper_run(payload=payload(), missing=missing(tmp_path)))
    assert len(listed) == 3
    text = clips_json(listed)
    assert "<" not in text, "stands in a script element"
    printed = json.loads(text)
    assert printed["page"].count(printed["place"]) == 1
    assert [json.loads(clip["data"]) for clip in printed["clips"]] == [
        json.loads(json.dumps(clip.data)) for clip in listed
    ]
    assert len(text) < LARGEST


def cut_to_what_is_drawn(browser: Browser, runs: int) -> None:
    """The picture for print has the machines at its top and the runs' names below each of them."""
    inside = "document.querySelector('.clips iframe').contentDocument.getElementById('machine')"
    whole = browser.run(f"{inside}.clientHeight")
    packed = browser.run("document.querySelector('.still').src").partition(",")[2]
    ink = browser.unpacked(base64.b64decode(packed)).max(axis=2) > 0
    rows = np.flatnonzero(ink.any(axis=1))
    # shadows at the edge of the floor are too faint to count as ink
    assert rows[0] <= 24
    assert len(ink) < 0.8 * whole
    below = ink[-20:]
    for half in np.array_split(below, runs, axis=1):
        columns = np.flatnonzero(half.any(axis=0))
        assert abs(columns.mean() / half.shape[1] - 0.5) < 0.1, "a name in the middle of its half"


def test_buttons_of_the_report_choose_the_clip(browser: Browser, tmp_path: Path) -> None:
    """Each clip is drawn, moves, and replaces the one before; the weight is there when it is on."""
    listed = clips(paper_run(payload=payload(), missing=missing(tmp_path)))
    body = (
        '{% extends "frame.html.j2" %}{% block body %}{% include "clips.html.j2" %}{% endblock %}'
    )
    text = page_html(
        "test", {}, {"test": body, "clips.html.j2": text_of("clips.html.j2")},
        title="clips", clips=clips_json(listed), clips_js=text_of("clips.js"),
    )  # fmt: skip
    page = tmp_path / "page.html"
    page.write_text(text, encoding="utf-8")
    browser.requests.clear()
    browser.open(page)
    texts, stills = set[str](), set[str]()
    for k, clip in enumerate(listed):
        browser.run(CHOOSE % k)
        inside = "document.querySelector('.clips iframe').contentWindow"
        pictures = []
        for t in (clip.data["begin"], clip.data["begin"] + 1.5):
            browser.run(f"{inside}.setTime({t})")
            pictures.append(browser.pixels())
        moved = np.abs(pictures[0] - pictures[1]).max(axis=2) > 40
        assert moved.mean() > 0.005, clip.title
        names = browser.run(
            "document.querySelector('.clips iframe').contentDocument"
            ".getElementById('runs').textContent"
        )
        assert names == "".join(run["name"] for run in clip.data["runs"])
        texts.add(browser.run("document.querySelector('.clips p').textContent"))
        shown = browser.run("document.querySelectorAll('.clips [aria-pressed=true]').length")
        assert shown == 1
        # print shows the machine as it stands
        browser.run("dispatchEvent(new Event('beforeprint'))")
        stills.add(browser.run("document.querySelector('.still').src"))
        cut_to_what_is_drawn(browser, len(clip.data["runs"]))
    assert texts == {clip.text for clip in listed}
    assert len(stills) == len(listed)
    assert all(still.startswith("data:image/png") and len(still) > 10_000 for still in stills)
    strangers = {url for url in browser.requests if not url.startswith(("blob:", "data:"))}
    assert strangers == {page.as_uri()}
    assert browser.said == []


def test_machine_without_a_platform_has_no_clip() -> None:
    alone = load_machine(MACHINE_FILE.with_name("tflex-actuators.toml"))
    assert clips(paper_run(machine=alone)) == []

"""Results in MCAP, as the library reads it that Foxglove's users have."""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path

import pytest

from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.ssp.result import Result
from flexhex.ssp.results import check_target, load, save
from tests.ssp.test_formats import N, result

__all__ = ["result"]
mcap = pytest.importorskip("mcap.reader", reason="the extra `mcap` is not installed")


def test_mcap_holds_a_topic_for_each_component(result: Result, tmp_path: Path) -> None:
    """As Foxglove and PlotJuggler read it: JSON with a schema, in the order of time."""
    path = save(result, tmp_path / "ü.mcap")
    with path.open("rb") as file:
        reader = mcap.make_reader(file)
        listed = [
            (schema, channel, message.log_time, json.loads(message.data, parse_constant=refused))
            for schema, channel, message in reader.iter_messages(log_time_order=False)
        ]
        (kept,) = reader.iter_metadata()
    times = [at for _, _, at, _ in listed]
    assert times == sorted(times)
    assert {channel.message_encoding for _, channel, _, _ in listed} == {"json"}
    by_topic: dict[str, list[tuple[int, dict[str, object]]]] = {}
    for _, channel, at, data in listed:
        by_topic.setdefault(channel.topic, []).append((at, data))
    assert {topic: len(m) for topic, m in by_topic.items()} == {
        "/plant": N, "/feedback": N, "/F": (N + 1) // 2, "/K": 6
    }  # fmt: skip
    assert [data["theta"] for _, data in by_topic["/plant"]] == result["plant.theta"].tolist()
    assert [at for at, _ in by_topic["/F"][:3]] == [0, 500_000, 1_000_000]
    assert by_topic["/feedback"][7][1]["e"] == [None] * 3
    assert by_topic["/K"][1][1]["p"] == {"actuator[1].o": 2 / 7, "lower.J_xx": 3 / 7}
    schemas = {channel.topic: json.loads(schema.data) for schema, channel, _, _ in listed}
    theta = schemas["/plant"]["properties"]["theta"]
    assert theta["items"]["description"] == 'angles, "encoder": ϑ [rad]'
    assert schemas["/K"]["properties"]["p"]["properties"]["lower.J_xx"]["type"] == "number"
    assert json.loads(kept.metadata["meta"])["case"] == "fixed"


def refused(word: str) -> None:
    raise AssertionError(f"{word} is no JSON")


def test_mcap_of_others_and_damaged_ones_are_refused(result: Result, tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    writer = importlib.import_module("mcap.writer").Writer(str(path))
    writer.start()
    writer.finish()
    with pytest.raises(LogError, match="not a result of flexhex"):
        load(path)
    whole = save(result, tmp_path / "r.mcap").read_bytes()
    for wrong in (whole[: len(whole) // 2], whole[:4000] + bytes(400) + whole[4400:], b"no"):
        path.write_bytes(wrong)
        with pytest.raises(LogError, match="MCAP file"):
            load(path)


def test_mcap_without_its_package_says_what_to_install(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = save(result, tmp_path / "r.mcap")
    for module in ("mcap.writer", "mcap.reader"):
        monkeypatch.setitem(sys.modules, module, None)
    for call in (check_target, load):
        with pytest.raises((UsageError, LogError), match=r"pip install 'flexhex\[mcap\]'"):
            call(path)

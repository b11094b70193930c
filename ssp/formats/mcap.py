"""Results in MCAP, as JSON messages: Foxglove, PlotJuggler and Lichtblick read them. Extra `mcap`.

The signals of a component at one rate are a topic (`/plant`), each sample one message whose log
time is that of the simulation. An array is a list, one whose elements have names an object; the
JSON schema of the topic has descriptions and units. A number that is none is null, an infinite
one 1e999. What reads a result back exactly stands in the metadata `flexhex`.
"""

from __future__ import annotations

import heapq
import importlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexhex.fmus.common.errors import LogError, UsageError
from flexhex.ssp.formats.about import about_result, refuse_version, result_of
from flexhex.ssp.result import FORMAT, Array, Group, Meta, Result

RECORD = "flexhex"
"""Name of the metadata that makes a file a result of ours."""
BLOCK = 4096
"""Rows that are made into messages at a time."""
NUMBERS = {"nan": "null", "inf": "1e999", "-inf": "-1e999"}
PACKAGE = "MCAP needs the package mcap: pip install 'flexhex[mcap]'"


@dataclass(frozen=True)
class Topic:
    """Signals of a group that are sent together. name: `/plant`."""

    name: str
    rate: str
    group: Group
    signals: tuple[str, ...]

    def field(self, signal: str) -> str:
        """Name of a signal in a message: without that of the component."""
        return signal.removeprefix(self.name.lstrip("/") + ".")


def check_installed(path: Path) -> None:
    """UsageError where mcap is missing."""
    try:
        importlib.import_module("mcap.writer")
    except ImportError:
        raise UsageError(f"{path}: {PACKAGE}") from None


def write(path: Path, result: Result, meta: Meta) -> None:
    """Write the result; OSError when that fails, UsageError without mcap."""
    check_installed(path)
    writer = importlib.import_module("mcap.writer").Writer(str(path))
    writer.start(profile="", library="flexhex")
    topics = _topics(result)
    channels = []
    for topic in topics:
        schema = json.dumps(_schema(topic), ensure_ascii=False).encode()
        number = writer.register_schema(f"flexhex{topic.name}", "jsonschema", schema)
        channels.append(writer.register_channel(topic.name, "json", number))
    streams = [_messages(topic, k) for k, topic in enumerate(topics)]
    for count, (at, k, text) in enumerate(heapq.merge(*streams)):
        writer.add_message(channels[k], at, text.encode(), at, count % 2**32)
    writer.add_metadata(RECORD, _about(result, topics, meta))
    writer.finish()


def _topics(result: Result) -> list[Topic]:
    """One for each component of each group; `/log` for signals without one."""
    topics: list[Topic] = []
    for rate, group in result.groups.items():
        parts: dict[str, list[str]] = {}
        for signal in group.signals:
            component, dot, _ = signal.partition(".")
            parts.setdefault(component if dot else "log", []).append(signal)
        for component, signals in parts.items():
            name, known = f"/{component}", {topic.name for topic in topics}
            name = next(n for n in (name, f"{name} {rate}", f"{name} {rate} 2") if n not in known)
            topics.append(Topic(name, rate, group, tuple(signals)))
    return topics


def _schema(topic: Topic) -> dict[str, Any]:
    """JSON schema of the messages of a topic; the unit stands in each description."""
    properties: dict[str, Any] = {}
    for signal in topic.signals:
        texts = [
            " ".join(filter(None, (topic.group.descriptions.get(signal, ""), f"[{unit}]")))
            for unit in topic.group.column_units(signal)
        ]
        each = [{"type": "number", "description": text} for text in texts]
        properties[topic.field(signal)] = (
            {"type": "object", "properties": dict(zip(_keys(topic, signal), each, strict=True))}
            if signal in topic.group.elements
            else {"type": "array", "items": each[0]}
            if topic.group.signals[signal].ndim > 1
            else each[0]
        )
    return {"type": "object", "title": topic.name, "properties": properties}


def _keys(topic: Topic, signal: str) -> list[str]:
    return [element.lstrip(".") for element in topic.group.elements[signal]]


def _messages(topic: Topic, place: int) -> Iterator[tuple[int, int, str]]:
    """Time [ns], place of the topic, JSON of each sample."""
    group, pattern = topic.group, _pattern(topic)
    values = [group.signals[signal] for signal in topic.signals]
    for first in range(0, group.rows, BLOCK):
        end = min(first + BLOCK, group.rows)
        block = np.hstack([v[first:end].reshape(end - first, -1) for v in values])
        times = np.rint(group.time[first:end] * 1e9).astype(np.int64).tolist()
        known = np.asarray(np.isfinite(block).all(axis=1))
        for at, good, row in zip(times, known, block.tolist(), strict=True):
            texts = map(repr, row)
            words = texts if good else (NUMBERS.get(text, text) for text in texts)
            yield at, place, pattern % tuple(words)


def _pattern(topic: Topic) -> str:
    """The JSON of a message with %s for each number."""
    fields = []
    for signal in topic.signals:
        if signal in topic.group.elements:
            keys = (json.dumps(key).replace("%", "%%") for key in _keys(topic, signal))
            value = "{" + ",".join(f"{key}:%s" for key in keys) + "}"
        elif topic.group.signals[signal].ndim > 1:
            value = "[" + ",".join(["%s"] * topic.group.signals[signal].shape[1]) + "]"
        else:
            value = "%s"
        fields.append(json.dumps(topic.field(signal)).replace("%", "%%") + ":" + value)
    return "{" + ",".join(fields) + "}"


def _about(result: Result, topics: list[Topic], meta: Meta) -> dict[str, str]:
    """What messages do not hold, as texts; `meta` stands there for people, too."""
    about = about_result(result, meta)
    for topic in topics:
        for signal in topic.signals:
            place = {"topic": topic.name, "field": topic.field(signal)}
            about["groups"][topic.rate]["signals"][signal].update(place)
    return {key: json.dumps(value, ensure_ascii=False) for key, value in about.items()}


def is_result(path: Path) -> bool:
    """Whether a file is a result of ours. OSError where it cannot be read."""
    with path.open("rb") as file:
        return _summary(path, file) is not None


def read(path: Path) -> Result:
    """Read a result that `write` wrote. LogError when it is none, or damaged, or without mcap."""
    with path.open("rb") as file:
        about = _summary(path, file)
        if about is None:
            raise LogError(f"{path}: an MCAP file, but not a result of flexhex")
        refuse_version(path, about)
        reader = importlib.import_module("mcap.reader").make_reader(file)
        rows: dict[str, list[Any]] = {}
        try:
            for _, channel, message in reader.iter_messages(log_time_order=False):
                rows.setdefault(channel.topic, []).append(json.loads(message.data))
            return result_of(about, lambda rate, signal: _samples(about, rows, rate, signal))
        except Exception as error:  # mcap's own classes
            raise LogError(f"{path}: a damaged MCAP file, maybe truncated ({error})") from None


def _summary(path: Path, file: Any) -> dict[str, Any] | None:
    """Our metadata in an MCAP file; None where it has none."""
    try:
        reader = importlib.import_module("mcap.reader")
    except ImportError:
        raise LogError(f"{path}: {PACKAGE}") from None
    try:
        records = list(reader.make_reader(file).iter_metadata())
        kept: dict[str, str] = next((r.metadata for r in records if r.name == RECORD), {})
        about = {key: json.loads(text) for key, text in kept.items()}
    except Exception as error:  # mcap's own classes
        raise LogError(f"{path}: not a readable MCAP file ({error})") from None
    file.seek(0)
    return about if about.get("format") == FORMAT else None


def _samples(about: dict[str, Any], rows: dict[str, list[Any]], rate: str, signal: str) -> Array:
    """A signal out of the messages of its topic."""
    entry = about["groups"][rate]["signals"][signal]
    parts = [message[entry["field"]] for message in rows.get(entry["topic"], [])]
    if entry["elements"]:
        parts = [list(part.values()) for part in parts]
    # null becomes the number that is none
    return np.array(parts, dtype=np.float64)

"""Measured or simulated runs as logs: one file is one run, each channel on its own clock."""

from diagnosis.logs.copies import refuse_copies
from diagnosis.logs.groups import RunGroup, group_runs
from diagnosis.logs.log import Channel, Finding, Log, Options
from diagnosis.logs.read import read_log

__all__ = [
    "Channel",
    "Finding",
    "Log",
    "Options",
    "RunGroup",
    "group_runs",
    "read_log",
    "refuse_copies",
]

"""Measured or simulated runs as logs: one file is one run, each channel on its own clock."""

from flexhex.diagnosis.logs.copies import refuse_copies
from flexhex.diagnosis.logs.cycles import with_cycles
from flexhex.diagnosis.logs.groups import RunGroup, group_runs, held_out
from flexhex.diagnosis.logs.joints import refuse_other_joints
from flexhex.diagnosis.logs.log import Channel, Finding, Log, Options
from flexhex.diagnosis.logs.read import read_log

__all__ = [
    "Channel",
    "Finding",
    "Log",
    "Options",
    "RunGroup",
    "group_runs",
    "held_out",
    "read_log",
    "refuse_copies",
    "refuse_other_joints",
    "with_cycles",
]

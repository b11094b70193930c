"""A study over random draws: the same draw every time, nothing run twice, nothing lost."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from flexhex.fmus.common.errors import InterfaceError, RunError, UsageError
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.machine_file import truth_file
from flexhex.fmus.common.model.parameters import base_parameters
from flexhex.simulation.builder import Builder
from flexhex.simulation.cases import table_cases
from flexhex.study.command import study_command
from flexhex.study.draws import StudyPlan, Values
from flexhex.study.pool import local, over_dask
from flexhex.study.store import Scored, Store
from flexhex.study.tasks import Task, carry_out, score, tasks
from tests.conftest import MACHINE_FILE, OUT, one_at_a_time

SHORT = 0.25
"""Judged time [s] where only the way matters, not the figures."""


@pytest.fixture(scope="module")
def out(builder: Builder, machine: Machine, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as `flexhex run` leaves it, with the parameters of the machine file as fit."""
    folder = tmp_path_factory.mktemp("out")
    for case in table_cases(machine, base_parameters(machine), 50.0)[1:]:
        with one_at_a_time(OUT):
            variant = builder.case(dataclasses.replace(case, name=f"study-{case.name}"))
        target = folder / "cases" / case.name
        target.mkdir(parents=True)
        shutil.copyfile(variant, target / "hexapod.ssp")
    return folder


def test_truth_draws_another_machine_of_the_same_make(out: Path) -> None:
    """Each run gets its own; that the seed of the file gives machine.fmu is what `tasks` checks."""
    listed = tasks(StudyPlan(2, varied=("truth", "drift")), MACHINE_FILE, out)
    sizes = {name: len(values) for name, values in listed[0].parameters.items()}  # type: ignore[arg-type]
    assert set(sizes) == {
        f"plant.{name}" for name in ("mechanism", "actuator", "hidden_cogging", "drift_torque")
    }
    first, second = (listed[k].parameters["plant.drift_torque"] for k in (0, 2))
    assert first != second


def test_both_cases_share_their_draw_and_keys_tell_all_apart(out: Path) -> None:
    listed = tasks(StudyPlan(3, SHORT), MACHINE_FILE, out)
    assert [(t.number, t.case) for t in listed[:3]] == [(1, "fixed"), (1, "adaptive"), (2, "fixed")]
    assert listed[0].parameters == listed[1].parameters
    more = [*listed, *tasks(StudyPlan(3, 2 * SHORT), MACHINE_FILE, out)]
    more += tasks(StudyPlan(3, SHORT, payload=2.0), MACHINE_FILE, out)
    assert len({t.key for t in more}) == 18
    assert [t.key for t in tasks(StudyPlan(4, SHORT), MACHINE_FILE, out)][:6] == [
        t.key for t in listed
    ]


def test_key_depends_on_the_system(out: Path, tmp_path: Path) -> None:
    shutil.copytree(out / "cases", tmp_path / "cases")
    path = tmp_path / "cases" / "fixed" / "hexapod.ssp"
    shutil.copyfile(out / "cases" / "adaptive" / "hexapod.ssp", path)
    a, b = (tasks(StudyPlan(1, SHORT), MACHINE_FILE, folder) for folder in (out, tmp_path))
    assert (a[0].key != b[0].key, a[1].key == b[1].key) == (True, True)


def test_missing_or_foreign_systems_are_refused(out: Path, tmp_path: Path) -> None:
    with pytest.raises(InterfaceError, match="run `flexhex run` first"):
        tasks(StudyPlan(1), MACHINE_FILE, tmp_path)
    other = tmp_path / "tflex.toml"
    shutil.copyfile(MACHINE_FILE, other)
    text = truth_file(MACHINE_FILE).read_text(encoding="utf-8")
    truth_file(other).write_text(text.replace("seed = 1", "seed = 2"), encoding="utf-8")
    with pytest.raises(UsageError, match=r"another machine than tflex \(mechanism differs\)"):
        tasks(StudyPlan(1), other, out)


def test_processes_give_what_a_direct_run_gives(out: Path, tmp_path: Path) -> None:
    """Two processes, four runs, the last bit; each draw has figures of its own."""
    listed = tasks(StudyPlan(2, SHORT), MACHINE_FILE, out)
    result = carry_out(StudyPlan(2, SHORT), listed, Store(tmp_path / "s.jsonl"), local(2))
    assert result.scored[listed[2].key] == score(listed[2])
    assert result.scored[listed[2].key] == score(listed[2], listed[2].ssp.read_bytes())
    assert len({s.e for s in result.scored.values()}) == 4
    assert all(s.faults == 0 and 1e-6 < s.e < 1e-2 for s in result.scored.values())


def test_refused_run_is_in_words_and_a_mistake_ends_the_study(out: Path) -> None:
    task = tasks(StudyPlan(1, SHORT), MACHINE_FILE, out)[0]
    times: Values = {"reference.payload_count": 2.0, "reference.payload_time": (0.0,) * 8}
    refused = dataclasses.replace(task, parameters=times)
    ((_, outcome),) = local(1)([refused])
    assert "must be later than" in str(outcome)
    unknown = dataclasses.replace(task, parameters={"plant.colour": 1.0})
    with pytest.raises(UsageError, match="there is no name 'colour'"):
        list(local(1)([unknown]))


def test_dask_gives_what_processes_give(out: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    listed = tasks(StudyPlan(1, SHORT), MACHINE_FILE, out)
    cluster = distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None
    )
    with cluster:
        pool = over_dask(cluster.scheduler_address)
        result = carry_out(StudyPlan(1, SHORT), listed, Store(tmp_path / "s.jsonl"), pool)
    assert [result.scored[t.key] for t in listed] == [score(t) for t in listed]


def test_dask_that_is_not_installed_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UsageError, match=r"pip install 'flexhex\[dask\]'"):
        over_dask("tcp://127.0.0.1:8786")


APP = """
import typer
from flexhex.study.command import study_command
app = typer.Typer()
app.command("study")(study_command)
app.callback()(lambda: None)
if __name__ == "__main__":
    app()
"""


def command(out: Path, *more: str) -> list[str]:
    """A study of eight runs, as typed."""
    return ["study", "-n", "4", "-d", "1", "-o", str(out), "-m", str(MACHINE_FILE), *more]


def test_command_writes_table_page_and_figures(out: Path) -> None:
    app = typer.Typer()
    app.command("study")(study_command)
    app.callback()(lambda: None)
    words = command(out, "--name", "a", "-n", "1", "-d", str(SHORT), "-j", "2")
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    assert re.search(r"adaptive feedforward +1 ", done.stdout)
    assert (out / "study" / "a.html").exists()
    assert len((out / "study" / "a.jsonl").read_text(encoding="utf-8").splitlines()) == 2
    again = json.loads(CliRunner().invoke(app, [*words, "--json"]).stdout)
    assert (again["kept"], set(again["cases"])) == (2, {"fixed", "adaptive"})


def test_ctrl_c_keeps_finished_runs_and_leaves_no_traceback(out: Path, tmp_path: Path) -> None:
    """The signal goes to all processes of the group, as a terminal sends it."""
    (tmp_path / "app.py").write_text(APP, encoding="utf-8")
    store = out / "study" / "c.jsonl"
    words = [
        sys.executable,
        str(tmp_path / "app.py"),
        *command(out, "--name", "c", "-j", "2", "-n", "6"),
    ]
    env = os.environ | {"PYTHONPATH": ":".join(map(os.path.abspath, sys.path[:]))}
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    # tests in the background of a shell ignore the signal, and so would what they start
    pipes["preexec_fn"] = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    running = subprocess.Popen(words, env=env, start_new_session=True, **pipes)
    end = time.monotonic() + 60
    # a file is there an instant before its first line is
    while not (store.exists() and store.stat().st_size) and running.poll() is None:
        assert time.monotonic() < end
        time.sleep(0.02)
    os.killpg(running.pid, signal.SIGINT)
    _, stderr = running.communicate(timeout=60)
    assert running.returncode == 130, stderr
    assert "Traceback" not in stderr
    assert "finished runs are in" in stderr
    kept = len(Store(store).done)
    assert 1 <= kept < 12
    done = subprocess.run([*words, "--json"], env=env, capture_output=True, text=True, check=True)
    data = json.loads(done.stdout)
    assert (data["kept"], len(data["runs"])) == (kept, 12)


def test_processes_do_not_hear_ctrl_c_and_the_leader_still_does(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed = tasks(StudyPlan(1, SHORT), MACHINE_FILE, out)
    monkeypatch.setattr("flexhex.study.pool.score", hearing)
    assert [s.faults for _, s in local(2)(listed) if isinstance(s, Scored)] == [0, 0]
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def hearing(task: Task) -> Scored:
    """faults is 1 where Ctrl-C would be heard."""
    heard = signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])
    return Scored(task.key, task.case, task.number, 1.0, 1.0, int(heard))


def test_broken_process_is_one_message(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    task = tasks(StudyPlan(1, SHORT), MACHINE_FILE, out)[0]
    monkeypatch.setattr("flexhex.study.pool.score", dying)
    with pytest.raises(RunError, match="a process of the study died"):
        list(local(1)([task]))


def dying(task: Task) -> Scored:
    """What a process does that runs out of memory."""
    os._exit(9)

"""The functions and classes that `import flexhex` offers; use them from there.

Paths may be text or `Path`. Whatever a user can mend is a `FlexhexError` that says what is wrong,
where, and how to mend it.

Long: the whole public interface in one file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from flexhex.arguments import SHIPPED
from flexhex.compare.results import Comparison, Tolerance, compare
from flexhex.diagnosis.estimation.excitation import excitation
from flexhex.diagnosis.estimation.extras import Extras
from flexhex.diagnosis.estimation.found import extras_of, read_diagnosis
from flexhex.diagnosis.estimation.identified import identify
from flexhex.diagnosis.estimation.identify import Fit, fit
from flexhex.diagnosis.estimation.inverse import left_out
from flexhex.diagnosis.estimation.plausible import listed_names
from flexhex.diagnosis.hypotheses.own_effect import own_effects
from flexhex.diagnosis.logs import Log, Options
from flexhex.diagnosis.logs import read_log as read
from flexhex.diagnosis.planning.trajectory import write_trajectory
from flexhex.diagnosis.prepare import Options as Search
from flexhex.diagnosis.workflow import Progress as DiagnosisProgress
from flexhex.diagnosis.workflow import diagnose, silent
from flexhex.fmus.common import machine_file as files
from flexhex.fmus.common.errors import (
    BuildError,
    FlexhexError,
    InterfaceError,
    LogError,
    MachineError,
    RunError,
    TrajectoryError,
    UsageError,
)
from flexhex.fmus.common.machine.machine import Machine
from flexhex.identify.any_base import Targets
from flexhex.python_arguments import listed, names, numbers, of_kind, reading, text
from flexhex.python_words import in_python, translated
from flexhex.shown import Diagnosis, Excitation, Identified, Written, shown
from flexhex.simulation.builder import Builder
from flexhex.ssp import results
from flexhex.ssp.executor import Parameters, run
from flexhex.ssp.results import Result
from flexhex.ssp.schedule import Progress
from flexhex.ssp.signals import DEFAULT
from flexhex.trajectory import variant

File = str | Path
Motors = str | Mapping[str, float | Sequence[float]]
__all__ = [
    "Build", "BuildError", "Comparison", "Diagnosis", "Excitation", "Fit", "FlexhexError",
    "Identified", "InterfaceError", "Log", "LogError", "Machine", "MachineError", "Result",
    "RunError", "TrajectoryError", "UsageError", "Written", "build_model", "compare_results",
    "diagnose_runs", "identify_parameters", "identify_runs", "load_machine", "load_result",
    "machine_file", "parameter_names", "plan_motion", "read_log", "save_identified", "save_result",
    "simulate_system", "with_trajectory",
]  # fmt: skip


@dataclass(frozen=True)
class Build:
    """What `build_model` wrote. fmus: by name (`plant`, `feedback` ...); model: the adaptive loop
    around the model (.ssp); machine: the same loop around machine.fmu, which has the errors and
    effects of the truth file, None without such a file."""

    fmus: Mapping[str, Path]
    model: Path
    machine: Path | None


def machine_file(name: str = "tflex") -> Path:
    """Path of a machine file that comes with the package.

    Raises MachineError for an unknown name.

    >>> flexhex.machine_file("tflex").name
    'tflex.toml'
    """
    path = SHIPPED / f"{name}.toml"
    if not path.is_file():
        known = sorted(p.stem for p in SHIPPED.glob("*.toml"))
        raise MachineError(f"no machine file {name!r} in the package; it has {', '.join(known)}")
    return path


def load_machine(path: File | None = None) -> Machine:
    """Read and check a machine file; without a path, that of the T-Flex.

    Raises MachineError, which names file, field and remedy.

    >>> flexhex.load_machine().n_arms
    6
    """
    return files.load_machine(machine_file() if path is None else Path(path))


def parameter_names(machine: Machine) -> list[str]:
    """Names of the parameters p of a machine, in the order of `Fit.p`.

    >>> len(flexhex.parameter_names(flexhex.load_machine()))
    162
    """
    return listed_names(machine)


def build_model(
    path: File | None = None, out: File = "out", platforms: Sequence[str] = ()
) -> Build:
    """Build the FMUs and system descriptions of a machine file into the folder `out`.

    path: the machine file; None is the T-Flex. platforms: `linux64`, `win64`, `aarch64-linux`,
    `darwin64`; default is this computer. FMUs that were built before come out of a cache.

    Raises MachineError (the file) and BuildError (no compiler, or it fails).

    >>> built = flexhex.build_model(out="out")
    >>> built.model.name
    'hexapod.ssp'
    """
    builder = Builder(
        machine_file() if path is None else Path(path), Path(out), platforms=tuple(platforms)
    )
    model, *machine = builder.systems()
    fmus = {fmu.stem: fmu for fmu in sorted((builder.out / "fmus").glob("*.fmu"))}
    return Build(fmus, model, machine[0] if machine else None)


def simulate_system(
    ssp: File,
    seconds: float,
    *,
    signals: Sequence[str] = (),
    parameters: Parameters | None = None,
    progress: Progress | None = None,
) -> Result:
    """Run a system description (.ssp) for `seconds`; each FMU at its own sample time.

    signals: further outputs to log, such as `K.p`; all but the largest arrays are logged anyhow.
    parameters: by component and name, `{"reference.seed": 3}`. progress(done, total) [s] is called
    about ten times a second.

    Raises UsageError (the arguments), InterfaceError (the .ssp), RunError (an FMU refuses a step).

    >>> result = flexhex.simulate_system("out/hexapod.ssp", 1.0)
    >>> result["plant.theta"].shape
    (4001, 6)
    """
    if not isinstance(seconds, int | float):
        raise UsageError(f"seconds = {seconds!r}: must be a number [s]")
    listed = [DEFAULT, *signals]
    result = run(ssp, seconds, signals=listed, parameters=parameters, progress=progress)
    provenance = results.provenance(command="flexhex.simulate_system")
    return Result(
        result.groups, result.times, result.duration, result.wall, {**provenance, **result.meta}
    )


def with_trajectory(
    ssp: File, trajectory: File, out: File = "out", machine: File | None = None
) -> Path:
    """Write `out/<ssp>-<trajectory>.ssp`: a system description along the motion of a CSV file.

    trajectory: angles `r` or poses `x_E`, `phi_E` (docs/motion.md). machine: the machine file that
    the .ssp was built from; None is the T-Flex. The motion begins after 2 s of rest.

    Raises TrajectoryError (what the file or the machine does not allow, with line and time),
    InterfaceError (no hexapod.ssp, or one of another machine) and BuildError.

    >>> path = flexhex.with_trajectory("out/hexapod.ssp", "motion.csv")
    """
    file = machine_file() if machine is None else Path(machine)
    return variant.with_trajectory(Path(ssp), Path(trajectory), file, Path(out)).path


def save_result(result: Result, path: File) -> Path:
    """Write a result with what made it, by the ending: .h5, .csv, .mat, .parquet, .mcap.

    LogError when it cannot be written.

    >>> path = flexhex.save_result(result, "result.h5")
    """
    return results.save(result, Path(path))


def load_result(path: File) -> Result:
    """Read a result of `save_result` or `flexhex simulate`. LogError for anything else.

    >>> result = flexhex.load_result("result.h5")
    """
    return results.load(Path(path))


@in_python
def read_log(
    path: File,
    *,
    torque_constant: float | Sequence[float] | None = None,
    motor: Motors | None = None,
    units: Mapping[str, str] | None = None,
    rename: Mapping[str, str] | None = None,
) -> Log:
    """Read a measured or simulated log: CSV, HDF5, MAT; Parquet, MDF4, MCAP and
    `.db3` with their extras.

    torque_constant [N m/A, N/A]: of a log in A, one or one for each axis. motor: of a log in V,
    "R=1.2 K_t=0.05 L=0.5 mH", or numbers in SI units, {"R": 1.2, "K_t": [0.05, 0.06]}, with R,
    K_t, K_e, L, gear and gain (docs/diagnose.md). units: by channel,
    `{"theta": "deg"}`, or for each axis, `{"theta": "deg, mm"}`. rename: name in the file ->
    channel. LogError for what cannot be read.

    >>> log = flexhex.read_log("result.h5")
    >>> log.theta.shape[1]
    6
    """
    return read(path, reading(torque_constant, units, rename, motor))


@in_python
def identify_parameters(
    machine: Machine, logs: Sequence[Log | File], *, settle: float = 2.0
) -> Fit:
    """Least-squares estimate of a machine's parameters p from logs of motions.

    settle [s] at the start of each log is left out. LogError for logs that do not determine p.

    >>> fit = flexhex.identify_parameters(machine, ["result.h5"])
    >>> names = flexhex.parameter_names(machine)
    """
    given = listed("logs", logs)
    return fit(machine, [g if isinstance(g, Log) else read(g, Options()) for g in given], settle)


@in_python
def identify_runs(
    runs: Sequence[Log | File],
    held_out: Sequence[Log | File] = (),
    *,
    base: str,
    tolerance: Mapping[str, float] | None = None,
    joints: Sequence[str] = (),
    settle: float | None = None,
    diagnosis: Diagnosis | File | None = None,
    effects: Sequence[str] = (),
    torque_constant: float | Sequence[float] | None = None,
    motor: Motors | None = None,
    units: Mapping[str, str] | None = None,
    rename: Mapping[str, str] | None = None,
) -> Identified:
    """Parameters of a robot, of axes or of a model of your own from measured runs, with 95 %
    intervals, as values that a machine can have (docs/identify.md).

    runs: logs of one machine, as paths or as `read_log` gives them. held_out: logs that are not
    fitted. base: `axis` (each by itself), a robot's file or the `.toml` beside it, or one of your
    own, `base.py:Arm`. tolerance: of a robot's file, `{"mass": 0.1}`. joints: of a robot's file,
    in the order of the logs' axes. settle [s]: left out at the start of each run.
    diagnosis: one, or the diagnosis.json that `flexhex diagnose` wrote; its effects are fitted with
    all parameters. effects: those of your own that it may have named, `effect.py:GasSpring`.
    torque_constant, motor, units, rename: how paths are read, as for `read_log`.

    Raises LogError, MachineError or UsageError for what cannot be read or does not fit.

    >>> identified = flexhex.identify_runs(["a.csv"], ["b.csv"], base="axis")
    >>> identified["J[1]"].estimate.ci95
    """
    if base == "hexapod":
        raise UsageError("base = 'hexapod': use identify_parameters")
    known = listed("runs", runs), listed("held_out", held_out)
    if settle is not None and not (isinstance(settle, int | float) and settle >= 0):
        raise UsageError(f"settle = {settle!r}: must be a number [s], not below zero")
    how = reading(torque_constant, units, rename, motor)
    chosen, own = names("joints", joints), names("effects", effects)
    options = Search(text("base", base), how, numbers("tolerance", tolerance), chosen, own)
    more: Extras | None = None
    if isinstance(diagnosis, Diagnosis):
        more = extras_of(diagnosis.data(), "diagnosis", own_effects(own))
    elif diagnosis is not None:
        more = read_diagnosis(Path(text("diagnosis", diagnosis)), own_effects(own))
    return shown(Identified, identify(*known, None, options, settle, more=more))


@in_python
def save_identified(identified: Identified, path: File) -> Written:
    """Write what was identified, by the ending: the robot's file with the new values (.urdf, .xml,
    as the base is), all values with intervals (.csv, .json), or the inverse dynamics as an FMU for
    feedforward (.fmu, docs/identify.md). Beside a robot's file a .toml holds what it has no place
    for, the next `base`, and a .json all values.

    Raises UsageError for another ending, FlexhexError where it cannot be written, BuildError
    without a C compiler, and MachineError for what cannot be written back or compiled.

    >>> written = flexhex.save_identified(identified, "inverse.fmu")
    >>> written.notes
    """
    found, file = of_kind("identified", identified, Identified), Path(text("path", path))
    targets = Targets(fmu=file) if file.suffix == ".fmu" else Targets(file)
    targets.check(found.base)
    files, notes = targets.write(found)
    if file.suffix == ".fmu":
        notes = left_out(found.estimated.extras)
    return Written(tuple(files), tuple(translated(note) for note in notes))


@in_python
def plan_motion(identified: Identified, path: File) -> Excitation:
    """Write a motion (.csv) that would determine more, and say how much: it stays within the
    positions, rates and accelerations of the runs.

    Raises UsageError for another ending, FlexhexError where it cannot be written.

    >>> planned = flexhex.plan_motion(identified, "next.csv")
    >>> planned.motion.r.shape
    """
    found, file = of_kind("identified", identified, Identified), Path(text("path", path))
    Targets(motion=file).check(found.base)
    planned = excitation(found)
    write_trajectory(planned.motion, file)
    return shown(Excitation, planned)


@in_python
def diagnose_runs(
    runs: Sequence[Log | File],
    held_out: Sequence[Log | File] = (),
    *,
    machine: File | None = None,
    base: str = "hexapod",
    tolerance: Mapping[str, float] | None = None,
    joints: Sequence[str] = (),
    effects: Sequence[str] = (),
    torque_constant: float | Sequence[float] | None = None,
    motor: Motors | None = None,
    units: Mapping[str, str] | None = None,
    rename: Mapping[str, str] | None = None,
    progress: DiagnosisProgress = silent,
) -> Diagnosis:
    """Find effects that measured runs show and the model lacks.

    runs: logs of one machine, several passes of several trajectories, as paths or as `read_log`
    gives them. held_out: logs of other trajectories, which are not fitted. machine: its machine
    file; None is the T-Flex, and nothing for other bases. base: `hexapod`, `axis` (each by itself),
    a robot's file or the `.toml` beside it, or one of your own, `base.py:Arm` (docs/own-base.md).
    tolerance: in place of the machine file's, `{"mass": 0.1}`. joints: of a robot's file, in the
    order of the logs' axes. effects: of your own, `effect.py:GasSpring` or a package's name
    (docs/own-effect.md), beside the library's. torque_constant, motor, units, rename: how paths are
    read, as for `read_log`.

    Raises LogError, MachineError or UsageError for what cannot be read or does not fit.

    >>> runs = ["a1.csv", "a2.csv", "b1.csv", "b2.csv"]
    >>> diagnosis = flexhex.diagnose_runs(runs, base="axis")
    >>> diagnosis.verdict
    """
    file = Path(machine) if machine is not None else None
    if file is None and base == "hexapod":
        file = machine_file()
    known = listed("runs", runs), listed("held_out", held_out)
    how, chosen = reading(torque_constant, units, rename, motor), names("joints", joints)
    own = names("effects", effects)
    options = Search(text("base", base), how, numbers("tolerance", tolerance), chosen, own)
    return shown(Diagnosis, diagnose(*known, file, options, progress))


def compare_results(
    first: Result | File,
    second: Result | File,
    *,
    atol: float = 0.0,
    rtol: float = 1e-9,
    signals: Mapping[str, float] | None = None,
    common: bool = False,
) -> Comparison:
    """Compare two results signal by signal; `Comparison.equal` says whether all agree.

    A difference of atol + rtol times the signal's largest value is allowed. signals: absolute
    tolerance of single signals, each in its unit. common: ignore what only one of them has.

    >>> flexhex.compare_results(result, "result.h5").equal
    True
    """
    a, b = (r if isinstance(r, Result) else load_result(r) for r in (first, second))
    return compare(a, b, Tolerance(atol, rtol, signals or {}), common)

"""Adaptive feedforward control of a flexure hexapod as FMI 2.0 co-simulation FMUs.

The names below are the public interface; `docs/api.md` shows each with an example. Every other
module and name is private and may change in any version. Importing `flexhex` loads nothing heavy:
a name brings its module along when it is used first.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

if not Path(__file__).with_name("fmus").is_dir():
    raise ImportError(
        f"{Path(__file__).with_name('fmus')} is not a folder: in a checkout it is a symbolic link,"
        " and this checkout was made without such links. Run `git config core.symlinks true` and"
        " then `git checkout HEAD -- flexhex` (on Windows as administrator or in developer mode),"
        " or install the wheel"
    )

from flexhex.fmugen import VERSION

if TYPE_CHECKING:
    from flexhex.api import (
        Build,
        BuildError,
        Comparison,
        Diagnosis,
        Excitation,
        Fit,
        FlexhexError,
        Identified,
        InterfaceError,
        Log,
        LogError,
        Machine,
        MachineError,
        Result,
        RunError,
        TrajectoryError,
        UsageError,
        Written,
        build_model,
        compare_results,
        diagnose_runs,
        identify_parameters,
        identify_runs,
        load_machine,
        load_result,
        machine_file,
        parameter_names,
        plan_motion,
        read_log,
        save_identified,
        save_result,
        simulate_system,
        with_trajectory,
    )

__version__ = VERSION
__all__ = [
    "Build",
    "BuildError",
    "Comparison",
    "Diagnosis",
    "Excitation",
    "Fit",
    "FlexhexError",
    "Identified",
    "InterfaceError",
    "Log",
    "LogError",
    "Machine",
    "MachineError",
    "Result",
    "RunError",
    "TrajectoryError",
    "UsageError",
    "Written",
    "__version__",
    "build_model",
    "compare_results",
    "diagnose_runs",
    "identify_parameters",
    "identify_runs",
    "load_machine",
    "load_result",
    "machine_file",
    "parameter_names",
    "plan_motion",
    "read_log",
    "save_identified",
    "save_result",
    "simulate_system",
    "with_trajectory",
]


def __getattr__(name: str) -> Any:
    """A public name on its first use. AttributeError for any other."""
    if name not in __all__:
        raise AttributeError(f"module 'flexhex' has no attribute {name!r}")
    from flexhex import api

    value = globals()[name] = getattr(api, name)
    return value


def __dir__() -> list[str]:
    """The public names."""
    return list(__all__)

"""Annotations of a .ssp: the base step where each importer looks for it, schedule, delays."""

from __future__ import annotations

from typing import Any

from flexhex.ssp.delays import path_delay
from flexhex.ssp.system import System
from flexhex.ssp.xml import child

SOLVER = "oms_ma_default"
"""OMSimulator's name for how components are stepped that name no solver. They must not name one:
its importFile refuses a component with annotations."""


def annotate_system(top: Any, system: System) -> None:
    """The step in OMSimulator's words; sample times and delays in base steps, for people and for
    our own executor."""
    annotations = child(top, "ssd:Annotations")
    _omsimulator(annotations, system.base)
    note = child(annotations, "ssc:Annotation", type="flexhex.schedule")
    schedule = child(note, "flexhex:Schedule", baseStep=repr(system.base))
    for component in system.components:
        steps = str(system.steps(component.name))
        child(schedule, "flexhex:Period", component=component.name, steps=steps)
    for path in system.paths:
        delay = path_delay(system, path)
        child(
            schedule,
            "flexhex:Delay",
            path=" ".join(path),
            shortest=str(delay.shortest),
            longest=str(delay.longest),
        )


def experiment(document: Any, base: float, stop: float) -> None:
    """DefaultExperiment, with the step where libcosim looks for it; stop [s]."""
    element = child(document, "ssd:DefaultExperiment", startTime="0.0", stopTime=repr(stop))
    annotations = child(element, "ssd:Annotations")
    osp = child(annotations, "ssc:Annotation", type="com.opensimulationplatform")
    algorithm = child(osp, "osp:Algorithm")
    child(algorithm, "osp:FixedStepAlgorithm", baseStepSize=repr(base))


def _omsimulator(annotations: Any, base: float) -> None:
    """The step for OMSimulator. It must be the system's first annotation: no other is looked at.

    importFile reads the child element; the Python classes (`SSP`) read the attributes.
    """
    step = repr(base)
    information = _simulation_information(
        annotations, name=SOLVER, method="oms_ma", fixedStepSize=step
    )
    child(
        information,
        "oms:FixedStepMaster",
        description="oms-ma",
        stepSize=step,
        relativeTolerance="0.0001",  # its schema demands one; a fixed step uses none
    )


def _simulation_information(annotations: Any, **attributes: str) -> Any:
    note = child(annotations, "ssc:Annotation", type="org.openmodelica")
    return child(child(note, "oms:Annotations"), "oms:SimulationInformation", **attributes)

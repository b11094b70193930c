"""Pinocchio's closed-loop solver on the nearest mechanism that it can express.

Its universal joint is two hinges in a row; the flexure's is a quaternion without twist, 2 q0 q1
= 0, equal to first order only, and no constraint of Pinocchio says that. So the numbers of this
rival are those of a neighbouring mechanism of the same size: 24 velocities, 18 closure
equations, 6 freedoms. `constraintDynamics` solves one closed-loop acceleration (not the
position, which N finds too) for given torques, called from Python.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pinocchio as pin

from benchmarks.clock import Rival
from tests.oracles.machine import Body, Machine, read_machine


def closed_model(machine: Machine) -> tuple[Any, list[Any]]:
    """The tree and its six closures at the points P."""
    model = pin.Model()
    placement = pin.SE3(np.eye(3), machine.x_E0)
    E = model.addJoint(0, pin.JointModelFreeFlyer(), placement, "E")
    model.appendBodyToJoint(E, _inertia(machine.end_effector), pin.SE3.Identity())
    ends = []
    for i in range(len(machine.x_B)):
        R_B0 = machine.R_B0[i]
        hinge = pin.JointModelRevoluteUnaligned(R_B0.T @ machine.axis[i])
        upper = model.addJoint(0, hinge, pin.SE3(R_B0, machine.x_B[i]), f"upper{i}")
        model.appendBodyToJoint(upper, _inertia(machine.upper), pin.SE3.Identity())
        universal = pin.JointModelUniversal(np.array([0.0, 1, 0]), np.array([0.0, 0, 1]))
        at = pin.SE3(R_B0.T @ machine.R_Q0[i], np.array([machine.L, 0, 0]))
        lower = model.addJoint(upper, universal, at, f"lower{i}")
        model.appendBodyToJoint(lower, _inertia(machine.lower), pin.SE3.Identity())
        ends.append((lower, pin.SE3(np.eye(3), np.array([machine.l, 0, 0]))))
    closures = [
        pin.RigidConstraintModel(
            pin.ContactType.CONTACT_3D, model, lower, end, E, pin.SE3(np.eye(3), machine.r_EP[i])
        )
        for i, (lower, end) in enumerate(ends)
    ]
    return model, closures


def constraint_dynamics() -> Rival:
    """One closed-loop acceleration at the neutral pose."""
    model, closures = closed_model(read_machine())
    data = model.createData()
    vector, pairs = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    vector.extend(closures)
    pairs.extend([closure.createData() for closure in closures])
    pin.initConstraintDynamics(model, data, vector, pairs)
    q, v, tau = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
    settings = pin.ProximalSettings(1e-12, 1e-10, 10)

    def run(count: int) -> float:
        begin = time.thread_time_ns()
        for _ in range(count):
            pin.constraintDynamics(model, data, q, v, tau, vector, pairs, settings)
        return (time.thread_time_ns() - begin) / count

    return Rival(
        "Pinocchio constraintDynamics", run, "a neighbouring mechanism, accelerations alone"
    )


def _inertia(body: Body) -> Any:
    return pin.Inertia(body.m, body.c, body.Ic)

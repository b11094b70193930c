"""The symbolic model of one machine, ready for the FMUs: closure, (24), (25), (26).

Every method takes and returns casadi.SX; an FMU wraps what it needs in functions.
"""

from __future__ import annotations

import casadi as ca

from flexhex.fmus.common import actuator
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model.constraints import Coordinates
from flexhex.fmus.common.model.dynamics import FrameMotion, loads, platform_jacobian, project
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.geometry import Frames
from flexhex.fmus.common.model.linkage import FreeArms, Linkage, half_angles
from flexhex.fmus.common.model.parameters import base_mechanism, mechanism_parameters, parameters


class Model:
    """Mechanism and actuators of a machine; n actuators, x~ of n_x, p of n_p values.

    chi is the basis of all actuators (n n_basis,), then the columns of `bank`, the effects
    that the model compensates; p has their gains behind the 162.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine, self.frames = machine, Frames.of(machine)
        self.n, self.n_x = machine.n_arms, len(self.frames.x0)
        self.n_p = len(parameters(machine))
        self.n_basis = 1 + 2 * machine.actuator.n_harmonics
        self.n_actuator = self.n_basis + 3
        self.bank = Bank.compensated(machine)
        self.split = self.n * self.n_actuator
        self.n_base = self.split + len(mechanism_parameters(machine))
        self.g = self._gravity()

    def _gravity(self) -> ca.SX:
        """g (3,) [m/s2], turned by what tilts the base."""
        g = ca.SX(list(self.machine.gravity.g))
        for use in self.machine.effects:
            if use.effect.acts_on == "mechanism":
                named = zip(use.effect.gains, use.gains, strict=True)
                g = use.effect.mechanism(g, {gain.name: value for gain, (value,) in named})
        return g

    def linkage(self, x: ca.SX, half: ca.SX | None = None) -> Linkage | FreeArms:
        """The closed loops at x~ (37,), or the free upper arms.

        half (2, n): `half_angles` of theta, where they are known already.
        """
        half = half_angles(x[: self.n]) if half is None else half
        if not self.machine.has_platform:
            return FreeArms(self.machine, half)
        return Linkage(self.frames, x, half)

    def motion(self, xd: ca.SX, xdd: ca.SX) -> FrameMotion:
        """Velocities and accelerations of all frames."""
        return FrameMotion(Coordinates.split(xd, self.n), Coordinates.split(xdd, self.n), self.g)

    def basis(self, theta: ca.SX, z: ca.SX) -> ca.SX:
        """Nonlinear actuator basis of all joints (n n_basis,): z, cos, sin, ... joint by joint."""
        a = self.machine.actuator
        columns = [
            actuator.basis(theta[i], a.omega_cog, a.n_harmonics, z[i]) for i in range(self.n)
        ]
        return ca.vertcat(*columns)

    def actuator_torque(self, p: ca.SX, theta: ca.SX, thetad: ca.SX, chi: ca.SX) -> ca.SX:
        """chi (n,) [N m] from actuator parameters p (n n_actuator,) and basis chi.  [Eq. (22)]"""
        torques = []
        for i in range(self.n):
            par = p[self.n_actuator * i : self.n_actuator * (i + 1)]
            part = chi[self.n_basis * i : self.n_basis * (i + 1)]
            torques.append(actuator.torque(par, theta[i], thetad[i], part))
        return ca.vertcat(*torques)

    def effect_torque(self, p: ca.SX, chi: ca.SX) -> ca.SX:
        """Torque (n,) [N m] of the effects: their gains in p times their columns in chi."""
        return self.bank.on_axes(p[self.n_base :], chi[self.n * self.n_basis :])

    def inverse_dynamics(self, x: ca.SX, xd: ca.SX, xdd: ca.SX, chi: ca.SX, p: ca.SX) -> ca.SX:
        """tau (n,) [N m] of a motion, parameters p (162,).  [SH, Eq. (24)]"""
        tau = self.base_torque(x, xd, xdd, chi, p)
        return tau + self.effect_torque(p, chi) if self.bank else tau

    def base_torque(self, x: ca.SX, xd: ca.SX, xdd: ca.SX, chi: ca.SX, p: ca.SX) -> ca.SX:
        """The same without effects."""
        linkage, par = self.linkage(x), base_mechanism(self.machine, p[self.split :])
        tau = project(linkage, loads(linkage, self.motion(xd, xdd), par))
        return tau + self.actuator_torque(p[: self.split], x[: self.n], xd[: self.n], chi)

    def regressor(self, x: ca.SX, xd: ca.SX, xdd: ca.SX, chi: ca.SX) -> ca.SX:
        """Phi (n, 162), sparse, with Phi p = tau.  [SH, Eq. (25), (26)]"""
        p, split = ca.SX.sym("p", self.n_base), self.split
        linkage = self.linkage(x)
        load = loads(linkage, self.motion(xd, xdd), base_mechanism(self.machine, p[split:]))
        wrench = ca.vertcat(load.force, load.moment)
        T = platform_jacobian(linkage)
        q = p[split:]
        mechanism = ca.jacobian(load.joint, q) + T.T @ ca.jacobian(wrench, q)
        chi_i = self.actuator_torque(p[:split], x[: self.n], xd[: self.n], chi)
        Phi = ca.horzcat(ca.jacobian(chi_i, p[:split]), ca.sparsify(mechanism))
        if not self.bank:
            return Phi
        return ca.horzcat(Phi, self.bank.matrix(chi[self.n * self.n_basis :]))

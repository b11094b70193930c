"""Forward dynamics of the plant: (24) solved for the joint accelerations.

Same model as the feedforward, with every parameter of every arm its own (`Mechanism`).
The mass matrix is assembled from the bodies' quadratic forms on the joint rates and the
platform's motion, then reduced by the loop closure: M = J^T M~ J of [SH, Eq. (13)].
"""

from __future__ import annotations

import casadi as ca

from flexhex.fmus.common import actuator
from flexhex.fmus.common.inertia import inertia_rows
from flexhex.fmus.common.machine.machine import Machine
from flexhex.fmus.common.model import quaternion as qn
from flexhex.fmus.common.model.bodies import Mechanism, mechanism_names, point_mass
from flexhex.fmus.common.model.dynamics import loads, platform_jacobian, project
from flexhex.fmus.common.model.effect_bank import Bank
from flexhex.fmus.common.model.linkage import ArmPose, FreeArms, Linkage
from flexhex.fmus.common.model.model import Model
from flexhex.fmus.common.model.solve import RowFactor, solve_symmetric
from flexhex.fmus.plant import effects


def spatial_inertia(par: ca.SX) -> ca.SX:
    """Quadratic form (6, 6) of a body in its own axes: on v of the origin and omega.

    par (10,): m, mc, J.   2 T = m v.v + 2 v.(omega x mc) + omega.J omega
    """
    m, S = par[0], ca.skew(par[1:4])
    J = ca.blockcat(inertia_rows([par[k] for k in range(4, 10)]))
    return ca.vertcat(ca.horzcat(m * ca.SX.eye(3), -S), ca.horzcat(S, J))


def rod_form(pose: ArmPose, par: ca.SX) -> ca.SX:
    """Lower arm's quadratic form (3, 3) on theta' and the motion of P_i across the rod.

    The motion across is (R_Q[:, 1], R_Q[:, 2]) . P_i'; the rod's spin follows from its twist row.
    """
    q, n_Q = pose.q, pose.n_Q
    den = q[0] ** 2 - q[1] ** 2
    drive = pose.R_Q.T @ (pose.L * pose.up)
    about_y = ca.horzcat(drive[2], 0, -1) / (pose.l * n_Q**2)
    about_z = ca.horzcat(-drive[1], 1, 0) / (pose.l * n_Q**2)
    spin = (q[1] * q[2] + q[0] * q[3]) * about_y - (q[0] * q[2] - q[1] * q[3]) * about_z
    about_x = (spin - ca.horzcat(pose.twist_rate(), 0, 0)) / den
    velocity = ca.horzcat(drive / n_Q, ca.SX(3, 2))
    motion = ca.vertcat(velocity, about_x, about_y, about_z)
    form: ca.SX = motion.T @ spatial_inertia(par) @ motion
    return form


def mass_matrix(linkage: Linkage | FreeArms, par: Mechanism) -> ca.SX:
    """M (n, n) [kg m2] that the joints feel."""
    if isinstance(linkage, FreeArms):
        alone: ca.SX = ca.diag(ca.vertcat(*(upper[0] for upper in par.upper)))
        return alone
    R_E = linkage.R_E
    E = spatial_inertia(par.end_effector)
    M_v = R_E @ E[:3, 3:]
    M_E = ca.vertcat(ca.horzcat(E[:3, :3], M_v), ca.horzcat(M_v.T, E[3:, 3:]))
    own, coupling = [], []
    for i, pose in enumerate(linkage.arms):
        form = rod_form(pose, par.lower[i])
        across = []
        for k in (1, 2):
            side = pose.R_Q[:, k]
            across.append(ca.vertcat(side, ca.cross(ca.SX(pose.arm.r_EP), R_E.T @ side)))
        Y = ca.horzcat(*across)
        M_E += Y @ form[1:, 1:] @ Y.T
        own.append(par.upper[i][0] + form[0, 0])
        coupling.append(form[0, 1:] @ Y.T)
    T = platform_jacobian(linkage)
    C = ca.vertcat(*coupling)
    half = C + (M_E @ T).T / 2
    mixed = half @ T
    M: ca.SX = ca.diag(ca.vertcat(*own)) + mixed + mixed.T
    return M


def with_payload(machine: Machine, par: Mechanism, payload: ca.SX) -> Mechanism:
    """The mechanism with a point mass `payload` [kg] at c_payload of E, if there is an E."""
    if not machine.has_platform:
        return par
    carried = par.end_effector + point_mass(payload, machine.platform.end_effector.c_payload)
    return Mechanism(par.upper, par.lower, carried, par.stiffness)


def current_decay(f_current: ca.SX, h: ca.SX) -> ca.SX:
    """How far a current loop gets in a time h [s]: its gap falls to exp(-decay)."""
    decay: ca.SX = 2 * ca.pi * f_current * h
    return decay


def drive_torque(
    tau: ca.SX, command: ca.SX, f_current: ca.SX, h: ca.SX
) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Torque (n,) [N m] of first-order current loops at start, middle and end of a time h [s].

        tau' = 2 pi f_current (command - tau)

    in closed form for a constant command. The middle value is the one for which Simpson's rule,
    which the integrator applies, gives the exact impulse.
    """
    reach = current_decay(f_current, h)
    mean = -ca.expm1(-reach) / reach
    gap = tau - command
    end = command + ca.exp(-reach) * gap
    return tau, effects.simpson_middle(tau, command + mean * gap, end), end


def functions(machine: Machine) -> list[ca.Function]:
    """Functions of step.c.

    plant_rates(theta, thetad, d, z, mechanism, actuator, payload)
        -> response (6, 7), dd (31,), zd (6,): thetadd = response (tau, 1)
    plant_dahl(z, delta) -> z_next (6,): after angle steps of one sign each
    plant_close(theta, d) -> d_next (31,), residual: one Newton correction and |D| before it
    plant_neutral() -> d (31,)
    plant_pose(d) -> x_E (3,), phi_E (3,) rotation vector of E; not without a platform
    plant_drive(tau_motor, command, f_current, h) -> start, middle, end (6,): `drive_torque`
    plant_decay(f_current, h) -> decay: `current_decay`

    With effects plant_rates has further arguments (`effects.Inputs`), tau is what the joints
    get, and the rates of their states come with it; `effects.functions` come too.
    """
    model = Model(machine)
    n, n_d = model.n, model.n_x - model.n
    theta, thetad, d = ca.SX.sym("theta", n), ca.SX.sym("thetad", n), ca.SX.sym("d", n_d)
    z, delta, payload = ca.SX.sym("z", n), ca.SX.sym("delta", n), ca.SX.sym("payload")
    mechanism = ca.SX.sym("mechanism", len(mechanism_names(n, machine.has_platform)))
    p = ca.SX.sym("actuator", n * model.n_actuator)

    linkage = model.linkage(ca.vertcat(theta, d))
    par = with_payload(machine, Mechanism.split(mechanism, n), payload)
    xd = linkage.rates(thetad)
    rest = linkage.accelerations(xd, ca.SX.zeros(n))
    bias = project(linkage, loads(linkage, model.motion(xd, rest), par))
    chi = model.actuator_torque(p, theta, thetad, model.basis(theta, z))
    M, force = mass_matrix(linkage, par), -chi - bias
    arguments, more_in = [theta, thetad, d, z, mechanism, p, payload], list[str]()
    rates, more_out = [xd[n:], actuator.dahl_rate(z, thetad, machine.actuator.sigma)], list[str]()
    bank, symmetric = Bank.all(machine), True
    if bank:
        given = effects.Inputs.of(bank)
        taken, added, stated = effects.torque(bank, theta, thetad, given)
        rows, columns = added.sparsity().get_triplet()
        force, M, symmetric = force - taken, M + added, rows == columns
        arguments, more_in = [*arguments, *given.symbols], list(effects.INPUT_NAMES)
        rates, more_out = [*rates, stated], ["stated"]
    solve = (lambda b: solve_symmetric(M, b)) if symmetric else RowFactor.of(M).solve
    unit = ca.SX.eye(n)
    response = ca.horzcat(*(solve(unit[:, i]) for i in range(n)), solve(force))

    listed = [
        ca.Function(
            "plant_rates",
            arguments,
            ca.cse([response, *rates]),
            ["theta", "thetad", "d", "z", "mechanism", "actuator", "payload", *more_in],
            ["response", "dd", "zd", *more_out],
        ),
        ca.Function(
            "plant_close",
            [theta, d],
            ca.cse([linkage.newton(), ca.norm_2(linkage.residual())]),
            ["theta", "d"],
            ["d_next", "residual"],
        ),
        ca.Function(
            "plant_dahl",
            [z, delta],
            [actuator.dahl(z, delta, machine.actuator.sigma)],
            ["z", "delta"],
            ["z_next"],
        ),
        ca.Function("plant_neutral", [], [ca.SX(model.frames.x0[n:])], [], ["d"]),
        *_drives(n),
        *effects.functions(bank),
    ]
    if machine.has_platform:
        x_E, phi_E = d[n_d - 7 : n_d - 4], qn.rotation_vector(d[n_d - 4 :])
        listed.append(ca.Function("plant_pose", [d], [x_E, phi_E], ["d"], ["x_E", "phi_E"]))
    return listed


def _drives(n: int) -> list[ca.Function]:
    tau, command = ca.SX.sym("tau_motor", n), ca.SX.sym("command", n)
    f_current, h = ca.SX.sym("f_current"), ca.SX.sym("h")
    return [
        ca.Function(
            "plant_drive",
            [tau, command, f_current, h],
            ca.cse(list(drive_torque(tau, command, f_current, h))),
            ["tau_motor", "command", "f_current", "h"],
            ["start", "middle", "end"],
        ),
        ca.Function(
            "plant_decay",
            [f_current, h],
            [current_decay(f_current, h)],
            ["f_current", "h"],
            ["decay"],
        ),
    ]

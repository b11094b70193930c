"use strict";
// Closed-form kinematics of the hexapod as the page needs them: angles in, frames of all bodies
// out. Vectors are arrays of 3, quaternions of 4, scalar first, body to world.

const vec = {
  add: (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]],
  sub: (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
  scale: (a, s) => [a[0] * s, a[1] * s, a[2] * s],
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
  unit: a => vec.scale(a, 1 / Math.hypot(...a)),
};

const quat = {
  multiply: (a, b) => [
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
  ],
  about: (axis, angle) => [Math.cos(angle / 2), ...vec.scale(axis, Math.sin(angle / 2))],
  unit: q => { const n = Math.hypot(...q); return q.map(c => c / n); },
  // v turned by q
  turn: (q, v) => {
    const u = q.slice(1), t = vec.scale(vec.cross(u, v), 2);
    return vec.add(vec.add(v, vec.scale(t, q[0])), vec.cross(u, t));
  },
  // the shortest turn that carries unit vector a to b
  between: (a, b) => quat.unit([1 + vec.dot(a, b), ...vec.cross(a, b)]),
  // from the axes of a frame, unit vectors x, y, z (Shepperd)
  ofAxes: (x, y, z) => {
    const trace = x[0] + y[1] + z[2], all = [trace, x[0], y[1], z[2]];
    const k = all.indexOf(Math.max(...all));
    if (k === 0) { return quat.unit([1 + trace, y[2] - z[1], z[0] - x[2], x[1] - y[0]]); }
    if (k === 1) { return quat.unit([y[2] - z[1], 1 + x[0] - y[1] - z[2], y[0] + x[1], z[0] + x[2]]); }
    if (k === 2) { return quat.unit([z[0] - x[2], y[0] + x[1], 1 + y[1] - x[0] - z[2], z[1] + y[2]]); }
    return quat.unit([x[1] - y[0], z[0] + x[2], z[1] + y[2], 1 + z[2] - x[0] - y[1]]);
  },
};

// x (6) of A x = b by elimination with pivots; null where A is singular
function solve6(A, b) {
  const M = A.map((row, i) => [...row, b[i]]), n = M.length;
  for (let k = 0; k < n; k++) {
    let p = k;
    for (let i = k + 1; i < n; i++) { if (Math.abs(M[i][k]) > Math.abs(M[p][k])) { p = i; } }
    if (Math.abs(M[p][k]) < 1e-12) { return null; }
    [M[k], M[p]] = [M[p], M[k]];
    for (let i = k + 1; i < n; i++) {
      const f = M[i][k] / M[k][k];
      for (let j = k; j <= n; j++) { M[i][j] -= f * M[k][j]; }
    }
  }
  const x = new Array(n).fill(0);
  for (let i = n - 1; i >= 0; i--) {
    let s = M[i][n];
    for (let j = i + 1; j < n; j++) { s -= M[i][j] * x[j]; }
    x[i] = s / M[i][i];
  }
  return x;
}

// Frames at neutral: per arm the unit vector along the lower arm, its frame Q and the upper arm's B.
function neutralFrames(machine) {
  return machine.arms.map(arm => {
    const Q = vec.add(arm.x_B, vec.scale(arm.u_B, machine.L));
    const rod = vec.unit(vec.sub(vec.add(machine.x_E0, arm.r_EP), Q));
    const y = vec.unit(vec.sub(arm.axis, vec.scale(rod, vec.dot(arm.axis, rod))));
    return {
      rod,
      lam_Q: quat.ofAxes(rod, y, vec.cross(rod, y)),
      lam_B: quat.ofAxes(arm.u_B, arm.axis, vec.cross(arm.u_B, arm.axis)),
    };
  });
}

// Pose of the end-effector for angles (6): Newton on |P - Q|^2 = l^2 of the six lower arms, from
// the pose `near`. {x, lam, converged}
function endEffector(machine, theta, near) {
  const Q = machine.arms.map((arm, i) =>
    vec.add(arm.x_B, vec.scale(quat.turn(quat.about(arm.axis, theta[i]), arm.u_B), machine.L)));
  let x = near.x, lam = near.lam;
  for (let k = 0; k < 30; k++) {
    const rows = [], gaps = [];
    machine.arms.forEach((arm, i) => {
      const r = quat.turn(lam, arm.r_EP), rod = vec.sub(vec.add(x, r), Q[i]);
      rows.push([...vec.scale(rod, 2), ...vec.scale(vec.cross(r, rod), 2)]);
      gaps.push(machine.l * machine.l - vec.dot(rod, rod));
    });
    const step = solve6(rows, gaps);
    if (!step) { break; }
    const size = Math.max(...step.map(Math.abs)), cut = Math.min(1, 0.3 / size);
    x = vec.add(x, vec.scale(step.slice(0, 3), cut));
    const turn = vec.scale(step.slice(3), cut), angle = Math.hypot(...turn);
    if (angle > 0) { lam = quat.unit(quat.multiply(quat.about(vec.scale(turn, 1 / angle), angle), lam)); }
    if (size < 1e-13) { return { x, lam, converged: true }; }
    if (size < 1e-9 && Math.max(...gaps.map(Math.abs)) < 1e-14) { return { x, lam, converged: true }; }
  }
  return { x, lam, converged: false };
}

// All bodies for angles (6): end-effector {x, lam}; per arm Q, P and the frames lam_B, lam_Q, rod
// direction, and where the neutral rod points to when the upper arm (rodB) or the end-effector
// (rodE) carries it; fits: it closes, and nothing turns or bends by a right angle. The universal joint has no twist: Q follows from rodB by the shortest turn.
function bodies(machine, neutral, theta, near) {
  const E = endEffector(machine, theta, near);
  const arms = machine.arms.map((arm, i) => {
    const turn = quat.about(arm.axis, theta[i]), rest = neutral[i];
    const Q = vec.add(arm.x_B, vec.scale(quat.turn(turn, arm.u_B), machine.L));
    const P = vec.add(E.x, quat.turn(E.lam, arm.r_EP));
    const rod = vec.unit(vec.sub(P, Q)), rodB = quat.turn(turn, rest.rod);
    return {
      Q, P, rod, rodB, turn,
      rodE: quat.turn(E.lam, rest.rod),
      lam_B: quat.multiply(turn, rest.lam_B),
      lam_Q: quat.multiply(quat.between(rodB, rod), quat.multiply(turn, rest.lam_Q)),
    };
  });
  const bent = arm => vec.dot(arm.rod, arm.rodB) <= 0 || vec.dot(arm.rod, arm.rodE) <= 0;
  const far = theta.some(angle => Math.abs(angle) >= Math.PI / 2);
  return { ...E, arms, fits: E.converged && !far && !arms.some(bent) };
}

"use strict";
// One mechanism as meshes: base, arms, end-effector, and flexures that bend between them.
// A ghost is the same mechanism, see-through and in one colour.

const BEND = 0.034;  // half length of a flexure [m] for an upper arm of 0.28 m
const PIECES = 10;

function vector(a) { return new THREE.Vector3(a[0], a[1], a[2]); }
function quaternion(q) { return new THREE.Quaternion(q[1], q[2], q[3], q[0]); }

// a mesh from a to b in the frame of its parent, of a geometry whose y runs from -1/2 to 1/2
function bar(geometry, material, a, b) {
  const mesh = new THREE.Mesh(geometry, material), along = b.clone().sub(a);
  mesh.position.copy(a).addScaledVector(along, 0.5);
  mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.clone().normalize());
  mesh.scale.y = along.length();
  mesh.castShadow = true;
  return mesh;
}

// how a body looks: one of a machine in its colour, one of a ghost see-through in its tint
function surface(tint, colour, metal, rough) {
  if (!tint) { return new THREE.MeshStandardMaterial({ color: colour, metalness: metal, roughness: rough }); }
  return new THREE.MeshStandardMaterial({
    color: tint, transparent: true, opacity: 0.38, depthWrite: false, roughness: 0.8,
    // behind the machine itself where both are at the same place
    polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 8,
  });
}

// motors coloured by shares of the largest (n), or plain for null
function colourHubs(materials, shares) {
  materials.forEach((material, i) => {
    if (shares) { material.color.setRGB(...ramp(shares[i]), THREE.SRGBColorSpace); }
    else { material.color.set("#9aa7b3"); }
    material.metalness = shares ? 0.1 : 0.5;
  });
}

// what `Stage` must know of a hexapod's size [m]
function hexapodReach(machine) {
  const [x, y, z] = machine.x_E0, reach = machine.L + machine.l;
  return { reach, middle: [x, y, 0.46 * z], floor: -0.088 * machine.L / 0.28 };
}

class Mechanism {
  // tint: CSS colour of a ghost, or null for the machine itself
  constructor(machine, neutral, tint) {
    Object.assign(this, { machine, neutral, tint, near: this.home(machine) });
    this.scale = machine.L / 0.28;
    this.h = BEND * this.scale;
    this.root = new THREE.Group();
    this.motors = [];
    this.uppers = machine.arms.map((arm, i) => this.upper(arm, i));
    this.lowers = machine.arms.map(() => this.lower());
    this.flexures = machine.arms.map((arm, i) => [this.flexure(i), this.flexure(i)]);
    this.platform = this.endEffector();
    if (!tint) { this.base(); }
  }

  home(machine) { return { x: [...machine.x_E0], lam: [1, 0, 0, 0] }; }

  material(colour, metal = 0.35, rough = 0.45) {
    return surface(this.tint, colour, metal, rough);
  }

  // motor with its arm, which turns about the axis: from x_B to where the flexure begins
  upper(arm, i) {
    const group = new THREE.Group(), s = this.scale;
    group.position.copy(vector(arm.x_B));
    const motor = this.material("#9aa7b3", 0.5, 0.4), metal = this.material("#c3cbd2");
    const rotor = new THREE.CylinderGeometry(0.036 * s, 0.036 * s, 0.052 * s, 40);
    const axis = vector(arm.axis);
    const hub = new THREE.Mesh(rotor, motor);
    hub.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), axis);
    hub.castShadow = true;
    const end = vector(vec.sub(vec.scale(arm.u_B, this.machine.L), vec.scale(this.neutral[i].rod, this.h)));
    const profile = new THREE.CylinderGeometry(0.0085 * s, 0.019 * s, 1, 4, 1);
    profile.rotateY(Math.PI / 4);
    const knob = new THREE.Mesh(new THREE.SphereGeometry(0.0125 * s, 20, 14), metal);
    knob.position.copy(end);
    group.add(hub, bar(profile, metal, vector([0, 0, 0]), end), knob);
    this.motors.push(motor);
    this.root.add(group);
    return group;
  }

  lower() {
    const s = this.scale, group = new THREE.Group();
    const rod = new THREE.Mesh(new THREE.CylinderGeometry(0.0075 * s, 0.0075 * s, 1, 20), this.material("#39434d", 0.2, 0.5));
    rod.castShadow = true;
    group.add(rod);
    for (const end of [-1, 1]) {
      const cap = new THREE.Mesh(new THREE.CylinderGeometry(0.011 * s, 0.011 * s, 0.02 * s, 20), this.material("#c3cbd2"));
      cap.userData.end = end;
      group.add(cap);
    }
    group.rod = rod;
    this.root.add(group);
    return group;
  }

  // a tube of PIECES rings whose points are set anew for each pose
  flexure() {
    const around = 12, count = (PIECES + 1) * around, faces = [];
    const geometry = new THREE.BufferGeometry();
    for (let k = 0; k < PIECES; k++) {
      for (let j = 0; j < around; j++) {
        const a = k * around + j, b = k * around + (j + 1) % around;
        faces.push(a, b, a + around, b, b + around, a + around);
      }
    }
    geometry.setIndex(faces);
    for (const name of ["position", "normal"]) {
      geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    }
    const mesh = new THREE.Mesh(geometry, this.material("#d8a028", 0.45, 0.35));
    mesh.frustumCulled = false;
    mesh.castShadow = !this.tint;
    this.root.add(mesh);
    return mesh;
  }

  // a cubic from a to b with end directions u and w (unit vectors)
  bend(mesh, a, b, u, w) {
    const place = mesh.geometry.attributes.position, out = mesh.geometry.attributes.normal;
    const length = 2 * this.h, around = 12, m0 = vec.scale(u, length), m1 = vec.scale(w, length);
    const side = vec.unit(vec.cross(u, Math.abs(u[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
    for (let k = 0; k <= PIECES; k++) {
      const t = k / PIECES, t2 = t * t, t3 = t2 * t;
      const c = [2 * t3 - 3 * t2 + 1, t3 - 2 * t2 + t, 3 * t2 - 2 * t3, t3 - t2];
      const d = [6 * t2 - 6 * t, 3 * t2 - 4 * t + 1, 6 * t - 6 * t2, 3 * t2 - 2 * t];
      const mix = f => vec.add(vec.add(vec.scale(a, f[0]), vec.scale(m0, f[1])),
        vec.add(vec.scale(b, f[2]), vec.scale(m1, f[3])));
      const p = mix(c), along = vec.unit(mix(d));
      const e1 = vec.unit(vec.sub(side, vec.scale(along, vec.dot(side, along)))), e2 = vec.cross(along, e1);
      // slender in the middle, as a flexure is
      const r = this.scale * (0.0042 + 0.0058 * Math.pow(Math.abs(2 * t - 1), 2.5));
      for (let j = 0; j < around; j++) {
        const g = 2 * Math.PI * j / around;
        const n = vec.add(vec.scale(e1, Math.cos(g)), vec.scale(e2, Math.sin(g)));
        place.setXYZ(k * around + j, ...vec.add(p, vec.scale(n, r)));
        out.setXYZ(k * around + j, ...n);
      }
    }
    place.needsUpdate = out.needsUpdate = true;
  }

  // plate through the ends of the flexures, with posts down to each of them
  endEffector() {
    const s = this.scale, group = new THREE.Group();
    const ends = this.machine.arms.map((arm, i) => vector(vec.add(arm.r_EP, vec.scale(this.neutral[i].rod, this.h))));
    const top = Math.max(...ends.map(p => p.z)) + 0.004 * s;
    const hull = [...ends].sort((p, q) => Math.atan2(p.y, p.x) - Math.atan2(q.y, q.x));
    const shape = new THREE.Shape();
    // corners rounded: from each to the next by a curve about the corner
    hull.forEach((p, k) => {
      const before = hull.at(k - 1), after = hull[(k + 1) % hull.length], out = 1.07, r = 0.022 * s;
      const corner = new THREE.Vector2(p.x * out, p.y * out);
      const towards = q => new THREE.Vector2(q.x * out, q.y * out).sub(corner).normalize().multiplyScalar(r).add(corner);
      const [a, b] = [towards(before), towards(after)];
      if (k) { shape.lineTo(a.x, a.y); } else { shape.moveTo(a.x, a.y); }
      shape.quadraticCurveTo(corner.x, corner.y, b.x, b.y);
    });
    shape.closePath();
    const hole = new THREE.Path();
    hole.absarc(0, 0, 0.075 * s, 0, 2 * Math.PI, true);
    shape.holes.push(hole);
    const geometry = new THREE.ExtrudeGeometry(shape, {
      depth: 0.01 * s, bevelEnabled: true, bevelSize: 0.002 * s, bevelThickness: 0.002 * s, bevelSegments: 2, curveSegments: 32,
    });
    const plate = new THREE.Mesh(geometry, this.material("#dfe5ea", 0.25, 0.4));
    plate.position.z = top;
    plate.castShadow = plate.receiveShadow = true;
    const ring = new THREE.Mesh(new THREE.TorusGeometry(0.078 * s, 0.005 * s, 14, 60), this.material("#6f7d8a"));
    ring.position.z = top + 0.012 * s;
    group.add(plate, ring);
    if (!this.tint) {
      this.load = this.weight();
      this.load.position.set(this.machine.c_payload[0], this.machine.c_payload[1], top + 0.012 * s);
      group.add(this.load);
    }
    const post = new THREE.CylinderGeometry(0.011 * s, 0.011 * s, 1, 20);
    for (const p of ends) {
      group.add(bar(post, this.material("#c3cbd2"), p, new THREE.Vector3(p.x, p.y, top + 0.001)));
    }
    this.root.add(group);
    return group;
  }

  // a cylinder as high as its radius, of unit radius, on a disc over the hole of the plate
  weight() {
    const group = new THREE.Group(), brass = this.material("#b5803a", 0.6, 0.35), s = this.scale;
    const disc = new THREE.Mesh(new THREE.CylinderGeometry(0.08 * s, 0.08 * s, 0.004 * s, 60), this.material("#6f7d8a"));
    const body = new THREE.Mesh(new THREE.CylinderGeometry(1, 1, 1, 60), brass);
    for (const part of [disc, body]) { part.rotateX(Math.PI / 2); part.castShadow = true; group.add(part); }
    group.body = body;
    group.visible = false;
    return group;
  }

  // the payload [kg], as large as if it were of aluminium
  carry(mass) {
    this.load.visible = mass > 0;
    const radius = Math.cbrt(mass / (2700 * Math.PI));
    this.load.body.scale.set(radius, radius, radius);
    this.load.body.position.z = radius / 2;
  }

  // disc with a post under each motor
  base() {
    const s = this.scale, steel = this.material("#6f7d8a", 0.3, 0.6);
    const radius = Math.max(...this.machine.arms.map(arm => Math.hypot(...arm.x_B.slice(0, 2)))) + 0.07 * s;
    const floor = -0.075 * s;
    const disc = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius * 1.03, 0.022 * s, 96), steel);
    disc.rotateX(Math.PI / 2);
    disc.position.z = floor;
    disc.receiveShadow = true;
    this.root.add(disc);
    for (const arm of this.machine.arms) {
      const foot = new THREE.Mesh(new THREE.BoxGeometry(0.062 * s, 0.03 * s, 0.075 * s), steel);
      foot.position.set(arm.x_B[0], arm.x_B[1], arm.x_B[2] + floor / 2);
      foot.rotation.z = Math.atan2(arm.axis[1], arm.axis[0]) + Math.PI / 2;
      foot.castShadow = foot.receiveShadow = true;
      this.root.add(foot);
    }
  }

  // bodies for these angles; false where the mechanism cannot take them
  place(theta) {
    let solved = bodies(this.machine, this.neutral, theta, this.near);
    if (!solved.fits) { solved = bodies(this.machine, this.neutral, theta, this.home(this.machine)); }
    if (!solved.fits) { this.near = this.home(this.machine); return false; }
    this.near = solved;
    const h = this.h, up = new THREE.Vector3(0, 1, 0);
    solved.arms.forEach((arm, i) => {
      this.uppers[i].quaternion.copy(quaternion(arm.turn));
      const begin = vec.add(arm.Q, vec.scale(arm.rod, h)), end = vec.sub(arm.P, vec.scale(arm.rod, h));
      const group = this.lowers[i], length = this.machine.l - 2 * h;
      group.position.copy(vector(vec.scale(vec.add(begin, end), 0.5)));
      group.quaternion.setFromUnitVectors(up, vector(arm.rod));
      group.rod.scale.y = length;
      for (const cap of group.children.slice(1)) { cap.position.y = cap.userData.end * length / 2; }
      this.bend(this.flexures[i][0], vec.sub(arm.Q, vec.scale(arm.rodB, h)), begin, arm.rodB, arm.rod);
      this.bend(this.flexures[i][1], end, vec.add(arm.P, vec.scale(arm.rodE, h)), arm.rod, arm.rodE);
    });
    this.platform.position.copy(vector(solved.x));
    this.platform.quaternion.copy(quaternion(solved.lam));
    return true;
  }

  paint(shares) { colourHubs(this.motors, shares); }
}

"use strict";
// A robot as meshes: a tree of joints that turn or slide, its bodies as its file shows them or as
// bars from joint to joint; or bars whose ends come with the run.
// Both have the members of `Mechanism`: root, place, paint, carry.

const HUB = 0.085, THIN = 0.55;  // radius of the first hub, of a machine of radius 1; of its bar
const SAMPLES = 60;  // instants that the size of a machine is taken from
const BENT = Math.cos(35 * Math.PI / 180);  // faces that meet at less are one round surface

// triangles with a normal at each corner; the machine and its ghosts share them
function geometryOf(mesh) {
  if (mesh.geometry) { return mesh.geometry; }
  const points = floats(mesh.points), faces = floats(mesh.faces), geometry = new THREE.BufferGeometry();
  const corner = k => [0, 1, 2].map(i => points[3 * faces[k] + i]), around = Array.from({ length: points.length / 3 }, () => []);
  const areas = [], places = new Float32Array(3 * faces.length), normals = new Float32Array(3 * faces.length);
  for (let k = 0; k < faces.length; k += 3) {
    const [a, b, c] = [corner(k), corner(k + 1), corner(k + 2)];
    areas.push(vec.cross(vec.sub(b, a), vec.sub(c, a)));
    for (let i = 0; i < 3; i++) { around[faces[k + i]].push(k / 3); }
  }
  const units = areas.map(area => vec.scale(area, 1 / Math.max(Math.hypot(...area), 1e-30)));
  for (let k = 0; k < faces.length; k++) {
    const own = units[Math.floor(k / 3)], near = around[faces[k]].filter(f => vec.dot(units[f], own) > BENT);
    places.set(corner(k), 3 * k);
    normals.set(vec.unit(near.map(f => areas[f]).reduce(vec.add, vec.scale(own, 1e-30))), 3 * k);
  }
  geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(normals, 3));
  return mesh.geometry = geometry;
}

// some points of a mesh, in the frame of its body
function pointsOf(mesh) {
  const points = floats(mesh.points), count = points.length / 3, step = Math.max(1, Math.floor(count / 200));
  return Array.from({ length: Math.ceil(count / step) }, (_, k) => [...points.slice(3 * k * step, 3 * k * step + 3)]);
}

// frames {x, q} of all joints, moved by theta (n): quaternions scalar first, body to world
function treeFrames(joints, theta) {
  const frames = new Array(joints.length);
  const frame = k => frames[k] ??= (() => {
    const joint = joints[k], on = joint.parent < 0 ? { x: [0, 0, 0], q: [1, 0, 0, 0] } : frame(joint.parent);
    const q = quat.multiply(on.q, joint.turn), x = vec.add(on.x, quat.turn(on.q, joint.at));
    return joint.turns
      ? { x, q: quat.multiply(q, quat.about(joint.axis, theta[k])) }
      : { x: vec.add(x, quat.turn(q, vec.scale(joint.axis, theta[k]))), q };
  })();
  joints.forEach((_, k) => frame(k));
  return frames;
}

// joints and ends of the bodies of a tree (n points)
function treePoints(joints, theta, ends) {
  return treeFrames(joints, theta).flatMap((f, k) => [f.x, ...ends[k].map(end => vec.add(f.x, quat.turn(f.q, end)))]);
}

// middle, radius and lowest height of what a machine reaches in the runs; as `Stage` wants them
function reachOf(machine, runs) {
  const low = [0, 0, 0], high = [0, 0, 0];
  if (machine.kind === "bars") { low.fill(Infinity); high.fill(-Infinity); }
  const ends = machine.joints?.map(({ mesh, tip }) => (mesh ? pointsOf(mesh) : [tip]));
  const widen = point => point.forEach((v, i) => { low[i] = Math.min(low[i], v); high[i] = Math.max(high[i], v); });
  for (const { frames } of runs) {
    for (let k = 0; k <= SAMPLES; k++) {
      const t = frames.t0 + frames.step * frames.count * k / SAMPLES;
      (machine.kind === "bars" ? barsAt(frames, t).flat() : treePoints(machine.joints, at(frames, "theta", t), ends)).forEach(widen);
    }
  }
  if (machine.foot) { pointsOf(machine.foot).forEach(widen); }
  const radius = Math.max(0.5 * Math.hypot(...vec.sub(high, low)), 1e-3);
  return { radius, reach: 1.08 * radius / 0.72, middle: vec.scale(vec.add(low, high), 0.5), floor: low[2] - (machine.foot ? 0 : 0.04 * radius) };
}

// ends [a, b] of all bars at t [s]
function barsAt(frames, t) {
  const count = frames.bars.length / frames.count, values = at(frames, "bars", t, count);
  return Array.from({ length: count / 6 }, (_, k) => [values.slice(6 * k, 6 * k + 3), values.slice(6 * k + 3, 6 * k + 6)]);
}

class Robot {
  constructor(machine, size, tint) {
    Object.assign(this, { machine, size, tint, hubs: [], root: new THREE.Group() });
  }

  material(colour, metal = 0.3, rough = 0.5) { return surface(this.tint, colour, metal, rough); }

  round(low, high, colour) {
    return [new THREE.CylinderGeometry(high, low, 1, 28), this.material(colour)];
  }

  // a shape of a file, seen from both sides: some have holes, or faces that look inwards
  shape(mesh, material) { return new THREE.Mesh(geometryOf(mesh), Object.assign(material, { side: THREE.DoubleSide })); }

  plain() { return this.material("#9aa7b3", 0.5, 0.4); }

  // what has the colour of a joint; r: how far from it its number stands
  hub(mesh, r) {
    mesh.castShadow = !this.tint;
    this.hubs.push(Object.assign(mesh.material, { mesh, r }));
    return mesh;
  }

  carry() { /* what a payload looks like, and where it is, no file says */ }

  paint(shares) { colourHubs(this.hubs, shares); }

  // where the joints are in the scene, and their radii, for their numbers
  get joints() { return this.hubs.map(({ mesh, r }) => [mesh.getWorldPosition(new THREE.Vector3()), r]); }
}

class Tree extends Robot {
  constructor(machine, size, tint) {
    super(machine, size, tint);
    const { joints } = machine;
    this.depth = joints.map(joint => { let n = 0; for (let on = joint.parent; on >= 0; on = joints[on].parent) { n++; } return n; });
    this.bodies = joints.map((joint, k) => this.body(joint, k));
    if (!tint) { this.foot(); }
    joints.forEach((joint, k) => { if (!joint.turns && !joint.mesh) { this.rail(joint, k); } });
  }

  // hubs get smaller towards the tool
  radius(k) { return this.size.radius * HUB * (1 - 0.5 * this.depth[k] / Math.max(1, ...this.depth)); }

  // what a joint moves, in its frame: its shape, or hub, bars to the joints that stand on it, or to its tip
  body(joint, k) {
    const group = new THREE.Group(), r = this.radius(k), axis = vector(joint.axis);
    this.root.add(group);
    if (joint.mesh) {
      group.add(this.hub(this.shape(joint.mesh, this.plain()), r));
      return group;
    }
    const body = joint.turns ? new THREE.CylinderGeometry(r, r, 2.7 * r, 40) : new THREE.BoxGeometry(1.7 * r, 2.4 * r, 1.7 * r);
    const hub = this.hub(new THREE.Mesh(body, this.plain()), 1.7 * r);
    hub.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), axis);
    group.add(hub);
    const { joints } = this.machine, next = joints.map((one, i) => [one, i]).filter(([one]) => one.parent === k);
    for (const [one, i] of next) { this.link(group, [0, 0, 0], one.at, THIN * r, THIN * this.radius(i), "#c3cbd2"); }
    if (!next.length && this.link(group, [0, 0, 0], joint.tip, THIN * r, 0.8 * THIN * r, "#c3cbd2")) { group.add(this.flange(joint.tip, r)); }
    return group;
  }

  // a bar, if it is long enough to be seen
  link(group, a, b, low, high, colour) {
    if (Math.hypot(...vec.sub(b, a)) < 0.3 * low) { return false; }
    const [geometry, material] = this.round(low, high, colour), mesh = bar(geometry, material, vector(a), vector(b));
    mesh.castShadow = !this.tint;
    group.add(mesh);
    return true;
  }

  flange(tip, r) {
    const mesh = bar(...this.round(0.75 * r, 0.75 * r, "#39434d"), vector(tip), vector(vec.add(tip, vec.scale(vec.unit(tip), 0.35 * r))));
    mesh.castShadow = !this.tint;
    return mesh;
  }

  // plate under the foot, and what carries the joints that stand on it
  foot() {
    if (this.machine.foot) {
      const mesh = this.shape(this.machine.foot, this.material("#6f7d8a"));
      mesh.castShadow = true;
      this.root.add(mesh);
      return;
    }
    const { joints } = this.machine, R = this.size.radius, first = joints.findIndex(joint => joint.parent < 0);
    const plate = [0, 0, this.size.floor], r = this.radius(first);
    const top = vec.add(plate, [0, 0, 0.04 * R]);
    this.root.add(bar(...this.round(0.22 * R, 0.21 * R, "#6f7d8a"), vector(plate), vector(top)));
    this.link(this.root, top, [0, 0, 0], 1.2 * r, 1.2 * r, "#6f7d8a");
    for (const joint of joints.filter(one => one.parent < 0)) { this.link(this.root, [0, 0, 0], joint.at, 1.2 * r, 0.8 * r, "#6f7d8a"); }
  }

  // what an axis slides along, fixed to the body before it, as far as the runs go
  rail(joint, k) {
    const places = DATA.runs.flatMap(({ frames }) => [...frames.theta].filter((_, i) => i % WIDTH === k));
    const ends = [places.reduce((a, b) => Math.min(a, b), 0), places.reduce((a, b) => Math.max(a, b), 0)];
    const room = 0.08 * this.size.radius, on = joint.parent < 0 ? this.root : this.bodies[joint.parent];
    const along = quat.turn(joint.turn, joint.axis), r = 0.4 * this.radius(k);
    const [a, b] = [ends[0] - room, ends[1] + room].map(d => vec.add(joint.at, vec.scale(along, d)));
    this.link(on, a, b, r, r, "#6f7d8a");
  }

  place(theta) {
    treeFrames(this.machine.joints, theta).forEach((f, k) => {
      this.bodies[k].position.copy(vector(f.x));
      this.bodies[k].quaternion.copy(quaternion(f.q));
    });
    return true;
  }
}

class Bars extends Robot {
  constructor(machine, size, tint) {
    super(machine, size, tint);
    const r = 0.5 * HUB * size.radius, count = DATA.runs[0].frames.bars.length / DATA.runs[0].frames.count / 6;
    this.bars = Array.from({ length: count }, (_, k) => {
      const mesh = new THREE.Mesh(...this.round(THIN * r, THIN * r, "#c3cbd2")), knob = new THREE.Mesh(new THREE.SphereGeometry(0.7 * r, 20, 14), this.material("#6f7d8a"));
      const hub = k < WIDTH ? this.hub(new THREE.Mesh(new THREE.SphereGeometry(1.3 * r, 28, 20), this.plain()), 1.3 * r) : null;
      mesh.castShadow = !tint;
      this.root.add(mesh, knob, ...(hub ? [hub] : []));
      return { mesh, knob, hub };
    });
  }

  place(theta, frames) {
    barsAt(frames, state.t).forEach(([a, b], k) => {
      const { mesh, knob, hub } = this.bars[k], along = vector(vec.sub(b, a));
      mesh.position.copy(vector(vec.scale(vec.add(a, b), 0.5)));
      mesh.scale.y = along.length();
      if (along.length() > 0) { mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.normalize()); }
      knob.position.copy(vector(b));
      hub?.position.copy(vector(a));
    });
    return true;
  }
}

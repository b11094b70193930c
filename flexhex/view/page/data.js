"use strict";
// The data of the page: numbers out of base64, values at a time, lines of runs.

const DATA = JSON.parse(document.getElementById("data").textContent);

function floats(text) {
  if (text === null) { return null; }
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) { bytes[k] = raw.charCodeAt(k); }
  return new Float32Array(bytes.buffer);
}

function decoded(run) {
  for (const name of ["theta", "e", "tau", "residual", "payload", "bars"]) { run.frames[name] = floats(run.frames[name]); }
}
DATA.runs.forEach(decoded);

const WIDTH = DATA.machine.names.length;

// of more than two runs one is shown at a time
const ALL = DATA.runs;
const SETTLED = DATA.settled;
function pick(run) {
  const settled = SETTLED < run.end ? Math.max(run.begin, SETTLED) : run.begin;
  Object.assign(DATA, { runs: [run], begin: run.begin, end: run.end, settled });
}
if (ALL.length > 2) { pick(ALL[0]); }

// the values of all joints in a channel of the frames at time t [s], linear between them; null without them
function at(frames, name, t, width = WIDTH) {
  const values = frames[name];
  if (!values) { return null; }
  const place = Math.min(Math.max((t - frames.t0) / frames.step, 0), frames.count - 1);
  const k = Math.min(Math.floor(place + 1e-6), Math.max(frames.count - 2, 0)), f = place - k, interpolated = [];
  for (let i = 0; i < width; i++) {
    const a = values[k * width + i], b = frames.count > 1 ? values[(k + 1) * width + i] : a;
    interpolated.push(a + f * (b - a));
  }
  return interpolated;
}

// payload at t [kg]: of the frame before it, since it comes at once
function payloadAt(frames, t) {
  const k = Math.floor((t - frames.t0) / frames.step + 1e-6);
  return frames.payload?.[Math.min(Math.max(k, 0), frames.count - 1)] ?? 0;
}

// angles at t with the error r - theta taken `factor` times; the wanted ones for factor 0
function angles(frames, t, factor) {
  const theta = at(frames, "theta", t), e = at(frames, "e", t);
  return e ? theta.map((value, i) => value + e[i] - factor * e[i]) : theta;
}

// the most by which a magnified error moves a joint [rad]: seen at once, and the loops still close
const FARTHEST = 0.25;

// how many times the error at t is drawn of `factor` times that are asked for
function magnified(frames, t, factor) {
  const most = Math.max(1e-12, ...(at(frames, "e", t) ?? []).map(Math.abs));
  return Math.min(factor, Math.max(1, FARTHEST / most));
}

// the largest magnitude of a channel in all runs, after `from` [s], of each joint
function largest(name, from) {
  const most = new Array(WIDTH).fill(0);
  for (const { frames } of DATA.runs) {
    const values = frames[name];
    if (!values) { continue; }
    const first = Math.min(Math.max(0, Math.ceil((from - frames.t0) / frames.step)), frames.count - 1);
    for (let k = first * WIDTH; k < values.length; k++) {
      const size = Math.abs(values[k]);
      if (size > most[k % WIDTH]) { most[k % WIDTH] = size; }
    }
  }
  return most;
}

// value of a line at t: the point before it
function valueAt(line, t) {
  const k = Math.floor((t - line.t0) / line.step + 1e-6);
  return k < 0 || k >= line.points.length ? NaN : line.points[k];
}

// the lines of a signal are unpacked when it is drawn first
function unpacked(signal) {
  for (const line of signal.lines) { line.points ??= floats(line.values); }
  return signal;
}

function signalOf(run, name) {
  return run.signals.find(signal => signal.name === name);
}

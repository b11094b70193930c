"use strict";
// The page: one time, one magnification, and whatever shows or changes them.

const byId = id => document.getElementById(id);
const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];
const FIRST = [["feedback.e", "e"], ["residual", "plant.tau_meas", "tau_meas", "feedback.tau"], ["plant.theta", "theta"]];

const state = { t: DATA.begin, playing: false, speed: 1, factor: 1, colour: "torque", ghost: "none", range: [DATA.begin, DATA.end] };
const SEEN = 5e-4;  // least angle between a machine and its ghost that is seen [rad]: a tenth of a pixel
let stage, plots, real, ghost, other, twin, dirty = true, last = 0;

function setTime(t) {
  state.t = Math.min(Math.max(t, DATA.begin), DATA.end);
  byId("time").value = state.t;
  byId("clock").innerHTML = `${state.t.toFixed(3)} s<span class="of"> of ${DATA.end.toFixed(1)} s</span>`;
  plots.cursor(state.t);
  dirty = true;
}

function setPlaying(playing) {
  state.playing = playing;
  if (playing && !LIVE && state.t >= state.range[1] - 1e-9) { setTime(state.range[0]); }
  byId("play").textContent = playing ? "❚❚" : "▶";
  byId("play").setAttribute("aria-label", playing ? "pause" : "play");
  last = performance.now();
  dirty = true;
}

function setFactor(exponent) {
  const e = Math.min(Math.max(exponent, 0), 4);
  byId("magnify").value = e;
  state.factor = 10 ** e;
  byId("factor").textContent = `${+state.factor.toPrecision(2)}`;
  dirty = true;
}

function setRange(range) {
  state.range = range;
  plots.zoom(range);
  dirty = true;
}

// what is drawn in green or in the colour of the second run; `beside` is no ghost, but a machine
function ghosts() {
  const list = [["none", "none"]];
  if (DATA.runs.length > 1) { list.unshift(["second", DATA.runs[1].name], ["beside", "beside each other"]); }
  if (DATA.runs[0].frames.e) { list.splice(list.length - 1, 0, ["wanted", "wanted pose"]); }
  return list;
}

// a ghost at the angles `at` over a machine at those of `of`, where one sees it: as much as a whole
// machine costs to draw; whether the mechanism can take them
function haunt(one, of, at) {
  one.root.visible = Boolean(at) && at.some((angle, i) => Math.abs(angle - of[i]) > SEEN);
  return !one.root.visible || one.place(at);
}

function place() {
  const factors = DATA.runs.map(run => magnified(run.frames, state.t, state.factor));
  const [mine, theirs] = DATA.runs.map((run, r) => angles(run.frames, state.t, factors[r]));
  const wanted = DATA.runs.map(run => angles(run.frames, state.t, 0)), beside = state.ghost === "beside";
  const fits = [real.place(mine), haunt(ghost, mine, { second: theirs, wanted: wanted[0], beside: wanted[0] }[state.ghost])];
  if (other) { fits.push(!beside || other.place(theirs), haunt(twin, theirs, beside && wanted[1])); }
  tell(factors, fits.every(Boolean));
  const channel = { torque: "tau", error: "e" }[state.colour];
  const most = channel ? tops[channel] || 1 : 1;
  for (const [machine, run] of [[real, DATA.runs[0]], [other, DATA.runs[1]]]) {
    const values = run && channel && at(run.frames, channel, state.t);
    machine?.carry(run ? payloadAt(run.frames, state.t) : 0);
    machine?.paint(values ? values.map(v => Math.abs(v) / most) : null);
  }
}

// what is drawn otherwise than asked for; beside each other, the names say how large their error is
function tell(factors, fits) {
  const times = factor => `error × ${+factor.toPrecision(2)}`, names = byId("names").children;
  [...names].forEach((name, r) => { name.textContent = DATA.runs[r].name + (state.factor > 1 ? `, ${times(factors[r])}` : ""); });
  const less = DATA.runs.findIndex((run, r) => factors[r] < state.factor && (r === 0 || state.ghost === "second"));
  byId("said").textContent = !fits ? "The mechanism cannot take these angles."
    : less < 0 || names.length ? "" : `${DATA.runs[less].name}: ${times(factors[less])} here, so that no joint is drawn more than ${FARTHEST} rad off.`;
}

const tops = {};
function setColour(name) {
  state.colour = byId("colour").value = name;
  const channel = { torque: "tau", error: "e" }[name];
  const known = channel && DATA.runs[0].frames[channel];
  if (known) { tops[channel] ??= largest(channel, DATA.settled); }
  const title = name === "torque" ? `|${DATA.runs[0].frames.torque === "residual" ? "residual" : "torque"}| of each motor` : "|tracking error| of each joint";
  const unit = name === "torque" ? "N m" : "rad";
  byId("legend").innerHTML = !channel ? "" : !known ? `the run has no ${name}`
    : `${title}<div class="ramp" style="background:${rampCss()}"></div><div class="ends"><span>0</span><span>${shown(tops[channel], unit)}</span></div>`;
  dirty = true;
}

function setGhost(name) {
  state.ghost = byId("ghost").value = name;
  const colour = name === "second" ? DATA.runs[1].colour : WANTED;
  byId("names").replaceChildren(...(name === "beside" ? DATA.runs : []).map(run =>
    Object.assign(document.createElement("span"), { textContent: run.name, style: `color: ${seen(run.colour)}` })));
  const apart = name === "beside" ? 0.78 * stage.reach : 0;
  if (other) {
    other.root.visible = apart > 0;
    other.root.position.x = twin.root.position.x = apart;
    real.root.position.x = ghost.root.position.x = -apart;
  }
  if (stage.wide !== 2 * apart) { stage.wide = 2 * apart; stage.look(apart ? "front" : "home"); byId("camera").value = apart ? "front" : "home"; }
  for (const one of [ghost, twin]) { one?.root.traverse(part => { part.material?.color.set(colour); }); }
  dirty = true;
}

function setTheme(dark) {
  document.documentElement.classList.toggle("dark", dark);
  stage?.colours();
  plots?.rebuild();
  if (ghost) { setGhost(state.ghost); }
  dirty = true;
}

function options(select, pairs) {
  select.replaceChildren(...pairs.map(([value, text]) => Object.assign(document.createElement("option"), { value, textContent: text })));
}

function next(select) {
  select.selectedIndex = (select.selectedIndex + 1) % select.options.length;
  select.dispatchEvent(new Event("change"));
}

function key(event) {
  const typing = ["SELECT", "DIALOG"].includes(event.target.tagName) || event.ctrlKey || event.metaKey || event.altKey;
  const slider = event.target.type === "range";
  const step = event.shiftKey ? 1 : DATA.runs[0].frames.step;
  const does = {
    " ": () => setPlaying(!state.playing),
    ArrowLeft: () => setTime(state.t - step), ArrowRight: () => setTime(state.t + step),
    Home: () => setTime(state.range[0]), End: () => setTime(state.range[1]),
    "+": () => setFactor(+byId("magnify").value + 0.25), "=": () => setFactor(+byId("magnify").value + 0.25),
    "-": () => setFactor(+byId("magnify").value - 0.25),
    ",": () => setSpeed(-1), ".": () => setSpeed(1),
    c: () => next(byId("colour")), g: () => next(byId("ghost")), v: () => next(byId("camera")),
    "?": () => byId("keys").showModal(),
  }[event.key];
  if (!does || typing || byId("keys").open) { return; }
  if (event.target === byId("magnify") && event.key.startsWith("Arrow")) { return; }
  if (event.target.tagName === "BUTTON" && event.key === " ") { if (event.target !== byId("play")) { return; } }
  if (event.key.startsWith("Arrow") && event.target === byId("machine")) { event.stopPropagation(); }
  if (slider || event.key === " " || event.key.startsWith("Arrow") || event.key === "Home" || event.key === "End") { event.preventDefault(); }
  does();
}

function setSpeed(by) {
  const k = Math.min(Math.max(SPEEDS.indexOf(state.speed) + by, 0), SPEEDS.length - 1);
  state.speed = SPEEDS[k];
  byId("speed").value = `${state.speed}`;
}

function fill() {
  for (const run of DATA.runs) {
    const text = document.createElement("span"), dot = document.createElement("i");
    dot.style.background = run.colour;
    text.append(dot, run.name);
    text.title = run.file;
    byId("runs").append(text);
  }
  options(byId("speed"), SPEEDS.map(s => [`${s}`, `× ${s}`]));
  byId("speed").value = "1";
  options(byId("ghost"), ghosts());
  const names = [...new Set(DATA.runs.flatMap(run => run.signals.map(signal => signal.name)))].sort();
  options(byId("add"), [["", "add a plot …"], ...names.map(name => [name, name])]);
  const joints = byId("joints");
  for (let i = 0; i < WIDTH; i++) {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: `${i + 1}` });
    button.title = `joint ${i + 1}`;
    button.style.borderColor = DATA.runs.length > 1 ? css("--edge") : JOINTS[i];
    const chosen = DATA.runs.length === 1 || i === 0;
    if (chosen) { plots.joints.add(i); }
    button.setAttribute("aria-pressed", `${chosen}`);
    button.addEventListener("click", () => {
      if (!plots.joints.delete(i)) { plots.joints.add(i); }
      button.setAttribute("aria-pressed", `${plots.joints.has(i)}`);
      plots.rebuild();
    });
    joints.append(button);
  }
  for (const wanted of DATA.begins.plots?.map(name => [name]) ?? FIRST) {
    const name = wanted.find(one => names.includes(one));
    if (name) { plots.add(name); }
  }
  Object.assign(byId("time"), { min: DATA.begin, max: DATA.end });
  byId("magnify").disabled = !DATA.runs[0].frames.e;
}

function listen() {
  byId("play").addEventListener("click", () => setPlaying(!state.playing));
  byId("time").addEventListener("input", event => { setPlaying(false); setTime(+event.target.value); });
  byId("magnify").addEventListener("input", event => setFactor(+event.target.value));
  byId("speed").addEventListener("change", event => { state.speed = +event.target.value; });
  byId("colour").addEventListener("change", event => setColour(event.target.value));
  byId("ghost").addEventListener("change", event => setGhost(event.target.value));
  byId("camera").addEventListener("change", event => stage.look(event.target.value));
  byId("add").addEventListener("change", event => {
    plots.add(event.target.value);
    event.target.value = "";
    byId("charts").lastElementChild?.scrollIntoView({ block: "nearest" });
  });
  byId("theme").addEventListener("click", () => setTheme(!document.documentElement.classList.contains("dark")));
  byId("help").addEventListener("click", () => byId("keys").showModal());
  window.addEventListener("keydown", key, true);
}

function frame(now) {
  const interval = now - last;
  last = now;
  if (state.playing && LIVE) {
    setTime(later(state.t, interval / 1000));
  } else if (state.playing) {
    const t = state.t + interval / 1000 * state.speed;
    if (t >= state.range[1]) { setTime(state.range[1]); setPlaying(false); } else { setTime(t); }
  }
  const anew = stage.pace(interval, dirty);
  if (dirty) { place(); }
  if (dirty || anew) { stage.draw(); }
  dirty = false;
  requestAnimationFrame(frame);
}

// the machine as it stands, for print
function still() {
  stage.draw();
  return byId("machine").toDataURL();
}

async function start() {
  document.documentElement.classList.toggle("framed", window.parent !== window);
  const media = window.matchMedia("(prefers-color-scheme: dark)");  // in a frame: that of the page around
  setTheme(media.matches);
  media.addEventListener("change", () => setTheme(media.matches));
  plots = new Plots(byId("charts"), { hover: t => { if (!state.playing) { setTime(t); } }, zoom: setRange });
  fill();
  listen();
  await loadThree();
  const neutral = neutralFrames(DATA.machine);
  stage = new Stage(byId("machine"), DATA.machine);
  stage.onChange = () => { dirty = true; };
  real = new Mechanism(DATA.machine, neutral, null);
  ghost = new Mechanism(DATA.machine, neutral, "#888888");
  other = DATA.runs.length > 1 ? new Mechanism(DATA.machine, neutral, null) : null;
  stage.add(real);
  twin = other && new Mechanism(DATA.machine, neutral, "#888888");
  [other, twin, ghost].forEach(one => { if (one) { stage.add(one); } });
  stage.colours();
  setColour(DATA.runs[0].frames.tau ? "torque" : DATA.runs[0].frames.e ? "error" : "none");
  setGhost(DATA.begins.ghost ?? ghosts()[0][0]);
  setFactor(Math.log10(DATA.begins.factor ?? 1));
  setRange([DATA.settled, DATA.end]);
  setTime(DATA.begins.t ?? DATA.settled);
  if (LIVE) { setPlaying(true); follow(); }
  requestAnimationFrame(now => { last = now; frame(now); document.documentElement.dataset.ready = "yes"; });
}

start().catch(error => {
  byId("said").textContent = `The machine cannot be drawn: ${error.message}`;
  console.error(error);
});

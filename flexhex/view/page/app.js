"use strict";
// The page: one time, one magnification, and whatever shows or changes them.

const byId = id => document.getElementById(id);
const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];
const FIRST = [["feedback.e", "e"], ["residual", "plant.tau_meas", "tau_meas", "feedback.tau"], ["plant.theta", "theta"]];
const FITTED = [["tau_smooth"], ["residual"], ["theta"]];  // of logs that a base model was fitted to

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
  if (DATA.runs[0].frames.e && posed()) { list.splice(list.length - 1, 0, ["wanted", "wanted pose"]); }
  return list;
}

// a ghost at the angles `at` over a machine at those of `of`, where one sees it: as much as a whole
// machine costs to draw; whether the mechanism can take them
function haunt(one, of, at, frames) {
  one.root.visible = Boolean(at) && at.some((angle, i) => Math.abs(angle - of[i]) > SEEN);
  return !one.root.visible || one.place(at, frames);
}

// whether the page itself knows where the bodies are at any angles
const posed = () => ["hexapod", "tree"].includes(DATA.machine.kind);

function place() {
  const factors = DATA.runs.map(run => magnified(run.frames, state.t, state.factor));
  const [mine, theirs] = DATA.runs.map((run, r) => angles(run.frames, state.t, factors[r]));
  const wanted = DATA.runs.map(run => angles(run.frames, state.t, 0)), beside = state.ghost === "beside";
  const [first, second] = DATA.runs.map(run => run.frames);
  const fits = [real.place(mine, first), haunt(ghost, mine, { second: theirs, wanted: wanted[0], beside: wanted[0] }[state.ghost], state.ghost === "second" ? second : first)];
  if (other) { fits.push(!beside || other.place(theirs, second), haunt(twin, theirs, beside && wanted[1], second)); }
  tell(factors, fits.every(Boolean));
  for (const [machine, run] of [[real, DATA.runs[0]], [other, DATA.runs[1]]]) {
    machine?.carry(run ? payloadAt(run.frames, state.t) : 0);
    machine?.paint(shares(run));
  }
}

// what is drawn otherwise than asked for; beside each other, the names say how large their error is
function tell(factors, fits) {
  const times = factor => `error\u00a0×\u00a0${+factor.toPrecision(2)}`, names = byId("names").children;
  [...names].forEach((name, r) => { name.textContent = DATA.runs[r].name + (state.factor > 1 ? `, ${times(factors[r])}` : ""); });
  const less = DATA.runs.findIndex((run, r) => factors[r] < state.factor && (r === 0 || state.ghost === "second"));
  byId("said").textContent = !fits ? "The mechanism cannot take these angles. Is it the log of another machine? Say which, with --base."
    : less < 0 || names.length ? "" : `${DATA.runs[less].name}: ${times(factors[less])} here, so that no joint is drawn more than ${FARTHEST} rad off.`;
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

function nameRuns() {
  if (ALL.length > 2) { return; }
  for (const run of DATA.runs) {
    const text = document.createElement("span"), dot = document.createElement("i");
    dot.style.background = run.colour;
    text.append(dot, run.name);
    text.title = run.file;
    byId("runs").append(text);
  }
}

function fill() {
  nameRuns();
  options(byId("speed"), SPEEDS.map(s => [`${s}`, `× ${s}`]));
  byId("speed").value = "1";
  options(byId("ghost"), ghosts());
  options(byId("colour"), colourings().map(name => [name, name]));
  options(byId("run"), ALL.map((run, k) => [k, run.name]));
  byId("run-label").hidden = ALL.length < 3;
  byId("note").textContent = [DATA.machine.text, DATA.said].filter(Boolean).join(" ");
  const names = [...new Set(ALL.flatMap(run => run.signals.map(signal => signal.name)))].sort();
  options(byId("add"), [["", "add a plot …"], ...names.map(name => [name, name])]);
  const joints = byId("joints"), fitted = names.includes("tau_smooth");
  // where the base model lacks most, to begin with
  const worst = fitted && known("tau") ? largest("residual", 0).map((v, i) => v / (largest("tau", 0)[i] || 1)).reduce((k, v, i, all) => (v > all[k] ? i : k), 0) : 0;
  joints.hidden = WIDTH < 2;
  for (let i = 0; i < WIDTH; i++) {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: `${i + 1}` });
    button.title = DATA.machine.names[i];
    button.style.borderColor = DATA.runs.length > 1 ? css("--edge") : JOINTS[i % JOINTS.length];
    const chosen = fitted ? i === worst : DATA.runs.length === 1 || i === 0;
    if (chosen) { plots.joints.add(i); }
    button.setAttribute("aria-pressed", `${chosen}`);
    button.addEventListener("click", () => {
      if (!plots.joints.delete(i)) { plots.joints.add(i); }
      button.setAttribute("aria-pressed", `${plots.joints.has(i)}`);
      plots.rebuild();
      dirty = true;
    });
    joints.append(button);
  }
  for (const wanted of DATA.begins.plots?.map(name => [name]) ?? (fitted ? FITTED : FIRST)) {
    const name = wanted.find(one => names.includes(one));
    if (name) { plots.add(name); }
  }
  Object.assign(byId("time"), { min: DATA.begin, max: DATA.end });
  byId("magnify").disabled = !DATA.runs[0].frames.e;
  byId("magnify").parentElement.hidden = !known("e") || !posed();
  byId("ghost-label").hidden = byId("ghost").options.length < 2;
}

// another one of the runs that are shown one at a time
function setRun(k) {
  pick(ALL[k]);
  Object.assign(byId("time"), { min: DATA.begin, max: DATA.end });
  for (const name of Object.keys(tops)) { delete tops[name]; }
  options(byId("ghost"), ghosts());
  setColour(state.colour);
  setGhost(byId("ghost").value);
  setPlaying(false);
  plots.rebuild();
  setRange([DATA.begin, DATA.end]);
  setTime(DATA.settled);
}

function listen() {
  byId("play").addEventListener("click", () => setPlaying(!state.playing));
  byId("time").addEventListener("input", event => { setPlaying(false); setTime(+event.target.value); });
  byId("magnify").addEventListener("input", event => setFactor(+event.target.value));
  byId("speed").addEventListener("change", event => { state.speed = +event.target.value; });
  byId("colour").addEventListener("change", event => setColour(event.target.value));
  byId("ghost").addEventListener("change", event => setGhost(event.target.value));
  byId("run").addEventListener("change", event => setRun(+event.target.value));
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

// machines and the stage that they stand on
async function build() {
  await loadThree();
  const { machine } = DATA, hexapod = machine.kind === "hexapod";
  const size = hexapod ? hexapodReach(machine) : reachOf(machine, ALL), neutral = hexapod && neutralFrames(machine);
  const tinted = tint => (hexapod ? new Mechanism(machine, neutral, tint) : new (machine.kind === "tree" ? Tree : Bars)(machine, size, tint));
  stage = new Stage(byId("machine"), size);
  stage.onChange = () => { dirty = true; };
  [real, ghost] = [tinted(null), tinted("#888888")];
  [other, twin] = DATA.runs.length > 1 ? [tinted(null), tinted("#888888")] : [null, null];
  [real, other, twin, ghost].forEach(one => { if (one) { stage.add(one); } });
  if (!hexapod && WIDTH > 1) { number(); }
}

// numbers beside the joints of the machine, in the colours of their lines; those that are chosen stand out
function number() {
  const canvas = byId("machine");
  const marks = DATA.machine.names.map((name, i) => Object.assign(document.createElement("span"), { textContent: i + 1, title: name }));
  byId("numbers").replaceChildren(...marks);
  stage.numbers = () => {
    const taken = [];
    real.joints.forEach(([at, radius], i) => {
      const right = new THREE.Vector3().setFromMatrixColumn(stage.camera.matrixWorld, 0);
      const p = at.addScaledVector(right, radius).project(stage.camera), x = (p.x + 1) / 2 * canvas.clientWidth + 2;
      let y = (1 - p.y) / 2 * canvas.clientHeight - 14;
      while (taken.some(([u, v]) => Math.abs(u - x) < 15 && Math.abs(v - y) < 15)) { y += 15; }
      taken.push([x, y]);
      marks[i].style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      marks[i].style.color = plots.joints.has(i) ? seen(DATA.runs.length > 1 ? DATA.runs[0].colour : JOINTS[i % JOINTS.length]) : "";
      marks[i].className = plots.joints.has(i) ? "chosen" : "";
    });
  };
}

// no picture: signals alone, so nothing has to be loaded, placed or drawn
function bodiless() {
  const body = () => ({ root: { visible: false, position: {}, traverse() {} }, place: () => true, paint() {}, carry() {} });
  stage = { reach: 0, wide: 0, look() {}, colours() {}, pace: () => false, draw() {} };
  [real, ghost] = [body(), body()];
  [other, twin] = DATA.runs.length > 1 ? [body(), body()] : [null, null];
}

async function start() {
  document.documentElement.classList.toggle("framed", window.parent !== window);
  const media = window.matchMedia("(prefers-color-scheme: dark)");  // in a frame: that of the page around
  setTheme(media.matches);
  media.addEventListener("change", () => setTheme(media.matches));
  plots = new Plots(byId("charts"), { hover: t => { if (!state.playing) { setTime(t); } }, zoom: setRange });
  fill();
  listen();
  const bare = DATA.machine.kind === "none";
  document.documentElement.classList.toggle("bare", bare);
  if (bare) { bodiless(); } else { await build(); }
  stage.colours();
  setColour(colourings()[0]);
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

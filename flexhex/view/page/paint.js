"use strict";
// Which figure of the joints colours them, on which scale, and the legend that says so.

const COLOURS = {
  residual: { channel: "residual", text: "residual", unit: "N m" },
  torque: { channel: "tau", text: "torque", unit: "N m" },
  error: { channel: "e", text: "tracking error", unit: "rad" },
};
const tops = {};  // by channel: what stands for the far end of the ramp, of each joint

const known = channel => ALL.some(run => run.frames[channel]);
function colourings() {
  return [...Object.keys(COLOURS).filter(name => known(COLOURS[name].channel)), "none"];
}

// motors of a hexapod are alike: one scale for all. Joints of an arm are not: each is compared with
// its own largest value, a residual with the largest torque of its joint.
const alike = () => DATA.machine.kind === "hexapod";
function scaled(channel) {
  const own = largest(channel, DATA.settled);
  if (alike()) { return own.fill(Math.max(...own) || 1); }
  const whole = channel === "residual" && known("tau") ? largest("tau", DATA.settled) : own;
  const most = Math.max(...own.map((v, i) => v / (whole[i] || 1))) || 1;
  return whole.map(v => (v || 1) * most);
}

// shares of the far end of the ramp for the joints of a run, or null where nothing colours them
function shares(run) {
  const channel = COLOURS[state.colour]?.channel, values = run && channel && at(run.frames, channel, state.t);
  return values ? values.map((v, i) => Math.abs(v) / tops[channel][i] || 0) : null;
}

function setColour(name) {
  state.colour = byId("colour").value = name;
  const { channel, text, unit } = COLOURS[name] ?? {};
  const there = channel && DATA.runs.some(run => run.frames[channel]);
  if (there) { tops[channel] ??= scaled(channel); }
  const end = () => {
    if (alike()) { return shown(tops[channel][0], unit); }
    const whole = channel === "residual" && known("tau") ? largest("tau", DATA.settled) : tops[channel];
    return `${+(100 * tops[channel][0] / (whole[0] || 1)).toPrecision(2)} %`;
  };
  const of = alike() ? (name === "error" ? "of each joint" : "of each motor")
    : channel === "residual" ? "of each joint, as a share of its largest torque" : "of each joint, as a share of its largest";
  byId("legend").innerHTML = !channel ? "" : !there ? `the run has no ${text}`
    : `|${text}| ${of}<div class="ramp" style="background:${rampCss()}"></div><div class="ends"><span>0</span><span>${end()}</span></div>`;
  dirty = true;
}

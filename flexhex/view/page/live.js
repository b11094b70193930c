"use strict";
// A run that goes on: the page asks its server for the newest seconds and follows them.

const LIVE = "live" in document.documentElement.dataset;
const ASK = 250;  // between two questions [ms]
const BEHIND = 0.4;  // how far the picture is behind the newest row, so that it moves evenly [s]
let count = -1;

function say(text, still) {
  byId("state").textContent = text;
  byId("state").className = still ? "still" : "";
}

async function follow() {
  let reply = null;
  try { reply = await (await fetch(`run.json?have=${count}`)).json(); } catch { /* nobody answers */ }
  if (!reply) { say("the view has ended: start it again", true); return; }
  say(reply.said || "live", reply.said);
  count = reply.count;
  if (reply.data.runs) { renew(reply.data); }
  setTimeout(follow, ASK);
}

function renew(data) {
  const whole = state.range[0] <= DATA.begin && state.range[1] >= DATA.end;
  data.runs.forEach(decoded);
  Object.assign(DATA, data);
  Object.assign(byId("time"), { min: DATA.begin, max: DATA.end });
  for (const name of Object.keys(tops)) { delete tops[name]; }
  setColour(state.colour);
  plots.renew();
  if (whole) { setRange([DATA.begin, DATA.end]); }
  setTime(state.t);
}

// the time that a picture shows `interval` [s] after the one before, while it follows the run
const later = (t, interval) => Math.min(Math.max(t + interval, DATA.end - 3 * BEHIND), DATA.end - BEHIND / 2);

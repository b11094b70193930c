"use strict";
// Colours: joints, scale for torque and error, and what CSS says of light and dark.

const JOINTS = ["#2f78b7", "#d9772b", "#3a9a5b", "#c0504d", "#8064a2", "#1f9aa8"];
const WANTED = "#1fa37a";  // ghost of the wanted pose
// from nothing to the largest: pale to red through amber; the same in light and dark
const RAMP = [[0.60, 0.68, 0.75], [0.98, 0.80, 0.35], [0.93, 0.48, 0.18], [0.75, 0.10, 0.15]];

function ramp(share) {
  const place = Math.min(Math.max(share, 0), 1) * (RAMP.length - 1);
  const k = Math.min(Math.floor(place), RAMP.length - 2), f = place - k;
  return RAMP[k].map((c, i) => c + f * (RAMP[k + 1][i] - c));
}

function rampCss() {
  const stops = RAMP.map(c => `rgb(${c.map(v => Math.round(255 * v)).join(" ")})`);
  return `linear-gradient(90deg, ${stops.join(", ")})`;
}

// a colour #rrggbb that was chosen for white paper: lighter on a dark ground
function seen(colour) {
  if (!document.documentElement.classList.contains("dark")) { return colour; }
  const parts = [1, 3, 5].map(k => parseInt(colour.slice(k, k + 2), 16));
  return `rgb(${parts.map(v => Math.round(v + 0.35 * (255 - v))).join(" ")})`;
}

function css(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

// 3 digits, with the unit that fits: 31.2 µrad; 0 where the smallest one would show nothing but rounding
const PREFIXES = [[1e-9, "n"], [1e-6, "µ"], [1e-3, "m"], [1, ""]];
function shown(value, unit) {
  const plain = !["rad", "m", "N m", "N", "rad/s", "rad/s2", "s", "V", "A"].includes(unit);
  const size = Math.abs(value);
  if (!Number.isFinite(value)) { return "–"; }
  if (!plain && size < 1e-3 * PREFIXES[0][0]) { return `0 ${unit}`; }
  if (plain) { return `${+value.toPrecision(4)} ${unit === "1" ? "" : unit}`.trim(); }
  const [scale, prefix] = PREFIXES.findLast(([s]) => size >= s * 0.9995) ?? PREFIXES[0];
  return `${+(value / scale).toPrecision(3)} ${prefix}${unit}`.replace("-", "−");
}

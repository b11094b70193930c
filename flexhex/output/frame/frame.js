"use strict";
// Plots of a page: colours of the scheme, one hover with names and units, linked time axes, one
// selector of joints, the data behind each plot, print. `figures`: plotly figures by id, whose
// layout.meta says more: time (a group of linked axes), joint (word of the selector), first;
// trace.meta: joint, panel, joins (a line that only joins points of others).

const root = document.documentElement;
const media = matchMedia("(prefers-color-scheme: dark)");
const PAPER = 700; // width of a plot in print [px]: A4 between its margins
const LONG = 26; // characters of the title of an axis below a narrow plot
const ROW = 22, FEW = 2; // height of a row of its legend [px], rows that make the plot no taller
const MENU = 44, UPRIGHT = 40; // height of a menu, what labels take that stand upright [px]
const LEFT = 66; // labels and title of an axis beside a narrow plot [px]
let chosen = "", joint = null, printing = false;
try { chosen = localStorage.getItem("flexhex-scheme") ?? ""; } catch { /* a page from a file may have no storage */ }

const isDark = () => !printing && (chosen ? chosen === "dark" : media.matches);
const narrow = () => !printing && innerWidth < 700;

// a colour that was chosen for white paper on a dark ground: greys turn round, others get lighter
function inDark(hex) {
  const full = hex.length === 4 ? hex.replace(/[0-9a-f]/gi, "$&$&") : hex;
  const rgb = [1, 3, 5].map(k => parseInt(full.slice(k, k + 2), 16) / 255);
  const high = Math.max(...rgb), low = Math.min(...rgb);
  const mixed = high - low < 0.12
    ? rgb.map(v => 1 - 0.9 * v)
    : rgb.map(v => (high + low < 1.1 ? v + 0.36 * (1 - v) : high + low > 1.4 ? 0.55 * v : v));
  return "#" + mixed.map(v => Math.round(255 * v).toString(16).padStart(2, "0")).join("");
}

const DATA = new Set(["x", "y", "text", "customdata", "hovertext", "error_y", "meta"]);
function coloured(value, key = "") {
  if (typeof value === "string") { return /^#([0-9a-f]{3}|[0-9a-f]{6})$/i.test(value) && isDark() ? inDark(value) : value; }
  if (value === null || typeof value !== "object" || DATA.has(key)) { return value; }
  if (Array.isArray(value)) { return value.map(one => coloured(one)); }
  return Object.fromEntries(Object.entries(value).map(([name, one]) => [name, coloured(one, name)]));
}

// what stands in brackets by itself: an element, theta[2], is no unit
const unitOf = title => /(^|\s)\[([^\]]+)\]/.exec(title ?? "")?.[2] ?? "";
const axisOf = (f, trace, name) => f.layout[`${name}axis${(trace[`${name}axis`] ?? "").slice(1)}`] ?? {};
const plain = text => (text ?? "").replace(/<sub>/g, "_").replace(/<\/su[bp]>/g, "").replace(/<[^>]*>/g, " ");

function layoutOf(f) {
  const axis = { gridcolor: "#e6e9ec", linecolor: "#bbb", zerolinecolor: "#bbb" };
  const layout = coloured({
    ...f.layout,
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    font: { ...f.layout.font, color: "#222" },
    template: { layout: { colorway: ["#1f6fb2", "#d1731d", "#3a8a4d", "#8a4fae", "#b8443c", "#6b5d4f", "#1a93a5", "#c0478c"], xaxis: axis, yaxis: axis } },
    modebar: { bgcolor: "rgba(0,0,0,0)", color: "#999", activecolor: "#1f6fb2" },
    hoverlabel: { namelength: -1, bgcolor: "#ffffff", bordercolor: "#999", font: { color: "#222" } },
  });
  const unit = unitOf(f.layout.xaxis?.title?.text), x = plain(f.layout.xaxis?.title?.text).replace(/(^|\s+)\[.*/, "");
  if (layout.hovermode === "x unified") {
    layout.xaxis = { ...layout.xaxis, unifiedhovertitle: { text: `${x} %{x:.5~g} ${unit}` } };
  }
  const zoomed = zooms[f.layout.meta?.time];
  if (zoomed) { layout.xaxis = { ...layout.xaxis, range: zoomed, autorange: false }; }
  if (layout.title?.text) { layout.title = { ...layout.title, text: layout.title.text.replaceAll("{joint}", joint ?? "") }; }
  if (panelsOf(f).length) {
    const box = document.getElementById(f.id);
    panelled(f, layout, printing ? PAPER : box.clientWidth);
    if (printing) { layout.width = PAPER; layout.autosize = false; }
    return layout;
  }
  const half = printing && f.layout.meta?.half;
  if (narrow() || half) {
    if (layout.title) {
      const text = wrapped(layout.title.text ?? "", 46), more = 16 * (text.split("<br>").length - 1);
      layout.margin.t = (layout.margin.t ?? 45) + more;
      layout.title = { ...layout.title, font: { size: 12.5 }, text, xref: "container", x: 0.03, yref: "container", y: 1, yanchor: "top", pad: { t: 12 } };
    }
  }
  if (narrow()) {
    // a wide margin to the right is the place of a legend
    layout.margin = { ...layout.margin, l: LEFT, r: layout.margin.r < 100 ? layout.margin.r : 10 };
    // no room beside the plot on a narrow screen: the legend goes below it, unless it stands above
    const named = f.data.filter(trace => trace.showlegend !== false && trace.visible !== false);
    if (layout.updatemenus) {
      // a menu of many lines stands above the plot; the pointer names them
      layout.updatemenus = layout.updatemenus.map(menu => ({ ...menu, x: 0, y: 1, yanchor: "bottom", pad: { b: 6 } }));
      Object.assign(layout, { showlegend: false, height: layout.height + MENU });
      layout.margin.t += MENU;
    } else if (named.length > 1 && layout.legend?.orientation !== "h") {
      const longest = Math.max(...named.map(trace => plain(trace.name).length));
      const each = 50 + 7.5 * longest + (named.some(trace => trace.legendgroup) ? 20 : 0);
      const rows = Math.ceil(named.length / Math.max(1, Math.floor((innerWidth - 90) / each)));
      layout.margin.b = 60 + ROW * rows;
      layout.height += ROW * Math.max(0, rows - FEW);
      layout.legend = { ...layout.legend, orientation: "h", x: 0, xanchor: "left", yref: "container", y: 0, yanchor: "bottom" };
    }
    if (layout.xaxis?.tickangle) {
      layout.xaxis = { ...layout.xaxis, tickangle: -90 };
      layout.margin.b += UPRIGHT;
      layout.height += UPRIGHT;
    }
  }
  if (narrow() && layout.xaxis?.title?.text?.length > LONG) {
    const text = wrapped(layout.xaxis.title.text, LONG);
    layout.xaxis = { ...layout.xaxis, title: { ...layout.xaxis.title, text } };
    layout.margin = { ...layout.margin, b: (layout.margin.b ?? 50) + 18 * (text.split("<br>").length - 1) };
  }
  if (printing) { layout.width = half ? PAPER / 2 - 20 : PAPER; layout.autosize = false; }
  return layout;
}

function wrapped(text, most) {
  const lines = [""];
  for (const word of text.split(" ")) {
    if ((lines.at(-1) + word).length > most) { lines.push(""); }
    lines[lines.length - 1] += (lines.at(-1) && " ") + word;
  }
  return lines.join("<br>");
}

function tracesOf(f) {
  const panels = shownPanels(f);
  return f.data.filter(trace => !panels.length || panels.includes(trace.meta.panel)).map(trace => {
    const drawn = coloured(trace), unit = unitOf(axisOf(f, trace, "y").title?.text);
    if (!trace.hovertemplate && !trace.hoverinfo && !trace.hovertext && (trace.mode ?? "").includes("lines")) {
      drawn.hovertemplate = `%{y:.4~g} ${unit}`;
    }
    if (panels.length) {
      const place = panels.indexOf(trace.meta.panel);
      return { ...drawn, xaxis: nth("x", place), yaxis: nth("y", place), hovertemplate: `${drawn.hovertemplate}<extra></extra>` };
    }
    if (trace.meta?.joint !== undefined) { drawn.visible = trace.meta.joint === joint; }
    return drawn;
  });
}

function draw(id) {
  const f = { ...figures[id], id }, box = document.getElementById(id), joints = jointsOf(f);
  // axes of several kinds have figures of their own
  box.closest("figure").hidden = joints.length > 0 && joint > 0 && !joints.includes(joint);
  return Plotly.react(box, tracesOf(f), layoutOf(f), {
    responsive: !printing, displaylogo: false, displayModeBar: narrow() ? false : "hover",
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
  });
}
const redraw = () => Promise.all(Object.keys(figures).map(draw));

// --- the data behind a plot ----------------------------------------------------------------------
const xOf = trace => trace.x ?? trace.y.map((_, k) => (trace.x0 ?? 0) + k * (trace.dx ?? 1));
const cell = value => (value === null || value === undefined ? "" : /[",\n]/.test(value) ? `"${String(value).replaceAll('"', '""')}"` : String(value));

// names of rows stand where the others have their x
const lying = trace => typeof trace.y?.[0] === "string";

// one column of x where all lines share it, else one beside each line; lines that join others' points are left out
function csvOf(id) {
  const f = figures[id], columns = [];
  let last = null;
  f.data.filter(trace => !trace.meta?.joins).forEach((trace, k) => {
    const [across, up] = lying(trace) ? ["y", "x"] : ["x", "y"], x = lying(trace) ? trace.y.map(plain) : xOf(trace);
    const same = last && last.length === x.length && last.every((v, i) => v === x[i]);
    const name = [plain(trace.name) || `line ${k + 1}`, trace.meta?.joint === undefined ? "" : `${f.layout.meta.joint} ${trace.meta.joint}`];
    if (!same) { columns.push([plain(axisOf(f, trace, across).title?.text) || (across === "y" ? "name" : "x"), x]); }
    const label = `${name.filter(Boolean).join(" ")}${axisOf(f, trace, up).title?.text ? `: ${plain(axisOf(f, trace, up).title.text)}` : ""}`;
    columns.push([label, trace[up]]);
    if (trace.error_y?.array) { columns.push([`${label}, ±`, trace.error_y.array]); }
    last = x;
  });
  const count = Math.max(0, ...columns.map(([, values]) => values.length));
  const rows = [columns.map(([label]) => cell(label))];
  for (let k = 0; k < count; k++) { rows.push(columns.map(([, values]) => cell(values[k]))); }
  return rows.map(row => row.join(",")).join("\n") + "\n";
}

function save(id) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([csvOf(id)], { type: "text/csv" }));
  link.download = `${id}.csv`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

// --- what stands above a plot --------------------------------------------------------------------
const jointsOf = f => [...new Set(f.data.map(trace => trace.meta?.joint).filter(one => one !== undefined))];

// what its buttons offer: also joints whose figures have another unit, or these could not be left
function offeredOf(f) {
  const own = jointsOf(f), word = f.layout.meta?.joint;
  if (panelsOf(f).length) { return own.length > 1 ? [0, ...own] : []; }
  const like = own.length ? Object.values(figures).filter(other => other.layout.meta?.joint === word) : [];
  return [...new Set(like.flatMap(jointsOf))].sort((a, b) => a - b);
}

function tools(id) {
  const f = figures[id], box = document.getElementById(id), frame = document.createElement("figure");
  box.replaceWith(frame);
  const bar = document.createElement("div");
  bar.className = "tools";
  const offered = offeredOf(f);
  if (offered.length > 1) {
    bar.append(f.layout.meta.joint);
    for (const number of offered) {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: number || "all" });
      button.dataset.joint = number;
      button.addEventListener("click", () => choose(number));
      bar.append(button);
    }
  }
  if (panelsOf(f).length) { bar.append(scaleButton(id)); }
  const data = Object.assign(document.createElement("button"), { type: "button", className: "data plain", textContent: "data (CSV)" });
  const title = plain(f.layout.title?.text) || plain(f.layout.yaxis?.title?.text), joints = jointsOf(f);
  data.setAttribute("aria-label", `download the data of ${title.replace("{joint}", [...new Set([joints[0], joints.at(-1)])].join(" to "))}`);
  data.addEventListener("click", () => save(id));
  bar.append(data);
  frame.append(bar, box);
}

function choose(number) {
  joint = number;
  root.classList.toggle("one-joint", number > 0);
  for (const button of document.querySelectorAll("[data-joint]")) { button.setAttribute("aria-pressed", Number(button.dataset.joint) === number); }
  return Promise.all(Object.keys(figures).filter(id => jointsOf(figures[id]).length).map(draw));
}

// --- time axes that are zoomed together ----------------------------------------------------------
let linking = false;
const zooms = {};  // what a group of axes shows, where that is not all; kept when plots are drawn anew
function link(id) {
  const group = figures[id].layout.meta?.time;
  if (!group) { return; }
  document.getElementById(id).on("plotly_relayout", change => {
    const begin = change["xaxis.range[0]"], reset = change["xaxis.autorange"] || change["xaxis.showspikes"] !== undefined;
    if (linking || (begin === undefined && !reset)) { return; }
    linking = true;
    if (begin === undefined) { delete zooms[group]; } else { zooms[group] = [begin, change["xaxis.range[1]"]]; }
    const range = begin === undefined ? { "xaxis.autorange": true } : { "xaxis.range": [begin, change["xaxis.range[1]"]] };
    const others = Object.keys(figures).filter(other => other !== id && figures[other].layout.meta?.time === group);
    Promise.all(others.map(other => Plotly.relayout(other, { ...range }))).finally(() => { linking = false; });
  });
}

// --- scheme, contents, print ---------------------------------------------------------------------
function scheme() {
  root.dataset.scheme = isDark() ? "dark" : "light";
  document.getElementById("scheme").textContent = isDark() ? "☀ light" : "☾ dark";
}

function contents() {
  const list = document.querySelector(".contents ol"), titles = [...document.querySelectorAll("main h2")];
  const seen = new Set();
  for (const title of titles.length > 2 ? titles : []) {
    let id = title.textContent.trim().toLowerCase().replace(/[^a-z0-9]+/g, "-");
    while (seen.has(id) || (document.getElementById(id) && document.getElementById(id) !== title)) { id += "-"; }
    seen.add(id);
    title.id = id;
    const link = Object.assign(document.createElement("a"), { href: `#${id}`, textContent: title.textContent });
    link.addEventListener("click", () => title.closest("details")?.setAttribute("open", ""));
    const item = document.createElement("li");
    item.append(link);
    list.append(item);
  }
  if (innerWidth < 1360) { document.querySelector(".contents details").open = false; }
}

const folded = () => [...document.querySelectorAll("details")];
let wasOpen = [];
function paper(on) {
  printing = on;
  if (on) { wasOpen = folded().map(one => one.open); }
  folded().forEach((one, k) => { one.open = on || wasOpen[k]; });
  scheme();
  return redraw();
}

document.getElementById("scheme").addEventListener("click", () => {
  chosen = isDark() ? "light" : "dark";
  try { localStorage.setItem("flexhex-scheme", chosen); } catch { /* only this page then */ }
  scheme();
  redraw();
});
media.addEventListener("change", () => { scheme(); redraw(); });
addEventListener("beforeprint", () => { paper(true); });
addEventListener("afterprint", () => { paper(false); });
// as many panels beside each other as there is room for
let width = innerWidth;
addEventListener("resize", () => {
  if (innerWidth === width || printing) { return; }
  width = innerWidth;
  Object.keys(figures).filter(id => panelsOf(figures[id]).length).forEach(draw);
});
// tips that would leave the window open to the left
for (const term of document.querySelectorAll(".term")) {
  const place = () => term.classList.toggle("leftward", term.getBoundingClientRect().left > innerWidth - 320 && innerWidth > 500);
  term.addEventListener("mouseenter", place);
  term.addEventListener("focus", place);
}
// a plot in a folded part has no width until it is opened
for (const part of folded()) {
  part.addEventListener("toggle", () => { part.querySelectorAll(".plot").forEach(box => box.data && Plotly.Plots.resize(box)); });
}

scheme();
contents();
joint = Object.values(figures).map(f => f.layout.meta?.first).find(first => first !== undefined) ?? 1;
Object.keys(figures).forEach(tools);
choose(joint);
redraw().then(() => {
  Object.keys(figures).forEach(link);
  Object.keys(figures).filter(id => panelsOf(figures[id]).length).forEach(together); root.dataset.ready = "yes"; });

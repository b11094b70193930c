"use strict";
// A signal of several joints as small multiples: a panel for each, in as many columns as there is
// room for. layout.meta.multiples says `names` of the panels; trace.meta.panel counts them from 0.

const PANEL = { height: 150, tall: 300, top: 26, foot: 30, side: 46, room: 280 };  // [px]

const panelsOf = f => f.layout.meta?.multiples?.names ?? [];
const shownPanels = f => panelsOf(f).map((_, k) => k).filter(k =>
  !joint || !jointsOf(f).length || f.data.some(trace => trace.meta.panel === k && trace.meta.joint === joint));
const nth = (name, k) => `${name}${k ? k + 1 : ""}`;

// columns that leave no row with less than half of its panels, where that can be
function columnsOf(count, width) {
  const most = Math.max(1, Math.min(count, 3, Math.floor(width / PANEL.room)));
  return count === 4 && most === 3 ? 2 : most;
}

// panels that are shown get axes in their order and places in the plot; changes `made`
function panelled(f, layout, width) {
  const shown = shownPanels(f), columns = columnsOf(shown.length, width), rows = Math.ceil(shown.length / columns);
  const high = shown.length === 1 ? PANEL.tall : PANEL.height, one = PANEL.top + high + PANEL.foot;
  const above = 4, below = 16, inner = width - 24, whole = rows * one;
  const size = narrow() ? 11 : 12, linked = shown.length > 1, same = linked && f.layout.meta.multiples.same;
  panelsOf(f).forEach((_, k) => { delete layout[nth("xaxis", k)]; delete layout[nth("yaxis", k)]; });
  const zoomed = zooms[f.layout.meta.time];
  Object.assign(layout, { height: above + whole + below, margin: { l: 10, r: 14, t: above, b: below }, showlegend: false, hovermode: "x", annotations: [], title: { text: "" } });
  shown.forEach((k, place) => {
    const [x, y] = [nth("xaxis", place), nth("yaxis", place)];
    const column = place % columns, row = Math.floor(place / columns), top = 1 - row * one / whole;
    const left = column / columns + PANEL.side / inner, right = (column + 1) / columns - (column + 1 < columns ? 10 : 0) / inner;
    const last = place + columns >= shown.length;
    layout[x] = {
      ...f.layout[x], domain: [left, right], anchor: nth("y", place), nticks: 6, tickfont: { size },
      title: { text: last ? f.layout[x].title.text : "", font: { size }, standoff: 4 }, ...(place ? { matches: "x" } : {}),
      ...(zoomed ? { range: zoomed, autorange: false } : {}),
    };
    layout[y] = {
      ...f.layout[y], domain: [top - (PANEL.top + high) / whole, top - PANEL.top / whole], anchor: nth("x", place), nticks: 4,
      tickfont: { size }, title: { text: "" }, ...(place && same ? { matches: "y" } : {}),
    };
    layout.annotations.push({
      text: panelsOf(f)[k], xref: "paper", yref: "paper", x: left, y: top - (PANEL.top - 4) / whole, xanchor: "left", yanchor: "bottom",
      showarrow: false, font: { size: 12.5 },
    });
  });
}

// a time under the pointer is shown in all panels
function together(id) {
  let spread = false;
  document.getElementById(id).on("plotly_hover", event => {
    if (spread || !event.points?.length) { return; }
    spread = true;
    const panels = shownPanels(figures[id]).map((_, place) => nth("x", place) + nth("y", place));
    Plotly.Fx.hover(id, { xval: event.points[0].x }, panels);
    spread = false;
  });
}

// the button that changes whether all panels have one scale
function scaleButton(id) {
  const { multiples } = figures[id].layout.meta;
  const button = Object.assign(document.createElement("button"), { type: "button", className: "scale", textContent: "one scale for all" });
  const press = () => button.setAttribute("aria-pressed", multiples.same);
  button.hidden = multiples.same === null;
  button.addEventListener("click", () => { multiples.same = !multiples.same; press(); draw(id); });
  press();
  return button;
}

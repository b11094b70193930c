"use strict";
// The plots: one for each chosen signal, all on one time axis and one cursor.

const TALL = 4;  // mean height of a column from which on bars are drawn [px]
const LEAST = 140, MOST = 260;  // height of a plot, which shares what room there is [px]
const BESIDE = { tau_smooth: [["tau_model", "model"]] };  // what is drawn over a signal, in dashes
const DASHES = [[], [6, 4], [2, 3], [9, 3, 2, 3]];  // columns of a signal where runs have the colours
const digits = (u, ticks) => ticks.map(v => (v === null ? "" : `${+v.toPrecision(7)}`.replace("-", "−")));
const seconds = (u, ticks) => digits(u, ticks).map(text => text && `${text} s`);

// Plots are drawn by the processor: through an emulated graphics card the same lines took seconds,
// for which everything else waited.
const anyContext = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, how) {
  return anyContext.call(this, kind, kind === "2d" ? { willReadFrequently: true, ...how } : how);
};

const unitsOf = chart => [...new Set(chart.lines.map(line => line.unit))];

class Plots {
  // on: {hover(t), zoom(range)}
  constructor(place, on) {
    Object.assign(this, { place, on, charts: [], joints: new Set(), range: [DATA.begin, DATA.end] });
    new ResizeObserver(() => this.resize()).observe(place);
  }

  get width() { return Math.max(200, this.place.clientWidth - 28); }

  get height() {
    const room = this.place.clientHeight / Math.max(1, this.charts.length) - 66;
    return getComputedStyle(this.place).overflowY === "auto" ? Math.min(Math.max(room, LEAST), MOST) : 170;
  }

  has(name) { return this.charts.some(chart => chart.name === name); }

  add(name) {
    if (this.has(name)) { return; }
    const box = document.createElement("div");
    box.className = "chart";
    box.innerHTML = '<h2></h2><button class="close" type="button">✕</button><div class="values"></div><div class="plot"></div>';
    box.querySelector(".close").setAttribute("aria-label", `close ${name}`);
    box.querySelector(".close").addEventListener("click", () => this.close(name));
    this.place.append(box);
    const chart = { name, box, values: box.querySelector(".values"), plot: null, lines: [] };
    this.charts.push(chart);
    this.build(chart);
    this.resize();
  }

  close(name) {
    const chart = this.charts.find(one => one.name === name);
    chart.plot?.destroy();
    chart.box.remove();
    this.charts = this.charts.filter(one => one !== chart);
    this.resize();
  }

  // the lines of new data; their units stand as long as the prefix fits
  renew() {
    for (const chart of this.charts) {
      chart.lines = this.lines(chart);
      if (this.unit(chart)[1] !== chart.prefix) { this.build(chart); }
    }
  }

  rebuild() { this.charts.forEach(chart => this.build(chart)); }

  // lines of a chart: of every run that has the signal the chosen columns
  lines(chart) {
    const lines = [];
    const listed = [[chart.name, ""], ...(BESIDE[chart.name] ?? [])];
    DATA.runs.flatMap((run, r) => listed.map(([name, word]) => [run, r, name, word])).forEach(([run, r, name, word]) => {
      const signal = signalOf(run, name);
      if (!signal) { return; }
      const six = signal.columns.length === WIDTH;
      unpacked(signal).columns.forEach((column, i) => {
        if (six && !this.joints.has(i)) { return; }
        const own = seen(DATA.runs.length > 1 ? run.colour : JOINTS[i % JOINTS.length]);
        const colour = word ? css("--ink") : own;  // over a line of the same colour no dash is seen
        const label = [(column || "").replace(/^\[(\d+)\]$/, "$1").replace(/^\./, ""), word].filter(Boolean).join(" ");
        const dash = word ? DASHES[1] : six || DATA.runs.length < 2 ? [] : DASHES[i % DASHES.length];
        lines.push({ ...signal.lines[i], colour, label, dash, run: r, unit: signal.units[i], count: signal.columns.length });
      });
    });
    return lines;
  }

  // factor and prefix that fit the largest value: [1e-3, "m"]
  unit(chart) {
    const units = unitsOf(chart);
    const most = Math.max(...chart.lines.map(line => line.points.reduce((m, v) => (Math.abs(v) > m ? Math.abs(v) : m), 0)), 0);
    const small = ["rad", "m", "N m", "N"].includes(units[0]) && units.length === 1 && most > 0;
    return small ? PREFIXES.findLast(([s]) => most >= s * 0.9995) ?? PREFIXES[0] : [1, ""];
  }

  build(chart) {
    chart.plot?.destroy();
    chart.lines = this.lines(chart);
    const unit = unitsOf(chart).join(", "), [scale, prefix] = this.unit(chart);
    chart.prefix = prefix;
    const bin = Math.max(1, ...chart.lines.map(line => line.bin));
    chart.box.querySelector("h2").innerHTML = "";
    const text = DATA.runs.map(run => signalOf(run, chart.name)?.text).find(Boolean) ?? "";
    chart.box.querySelector("h2").append(chart.name, " ", Object.assign(document.createElement("small"), {
      textContent: `${text ? `${text} · ` : ""}${prefix}${unit === "1" ? "" : unit}${bin > 1 ? ` · extremes of every ${bin} samples` : ""}`,
    }));
    const axis = { stroke: css("--dim"), grid: { stroke: css("--grid"), width: 1 }, ticks: { show: false }, font: "12px system-ui" };
    chart.plot = new uPlot({
      width: this.width, height: this.height, legend: { show: false }, padding: [8, 14, 0, 0],
      cursor: {
        y: false, points: { show: false }, drag: { x: true, y: false, setScale: false },
        bind: { dblclick: () => () => { this.on.zoom([DATA.begin, DATA.end]); return null; } },
      },
      scales: {
        x: { time: false, range: () => this.range },
        y: { range: () => this.extent(chart, scale) },
      },
      axes: [{ ...axis, size: 28, values: seconds }, { ...axis, size: 50, values: digits }],
      series: [{}, { show: true, paths: () => null, points: { show: false } }],
      hooks: {
        draw: [u => chart.lines.forEach(line => this.stroke(u, line, scale))],
        setCursor: [u => { if (u.cursor.event && u.cursor.left >= 0) { this.on.hover(u.posToVal(u.cursor.left, "x")); } }],
        setSelect: [u => {
          if (u.select.width > 4) {
            this.on.zoom([u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x")]);
          }
          if (u.select.width) { u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false); }
        }],
      },
    }, [this.range, [0, 0]], chart.box.querySelector(".plot"));
    this.cursor(this.time ?? DATA.begin);
  }

  // points of a line in the shown range, one before and one after
  shown(line) {
    const place = t => (t - line.t0) / line.step, last = line.points.length - 1;
    return [Math.max(0, Math.floor(place(this.range[0]))), Math.min(last, Math.ceil(place(this.range[1])))];
  }

  extent(chart, scale) {
    let low = Infinity, high = -Infinity;
    for (const line of chart.lines) {
      const [first, last] = this.shown(line);
      for (let k = first; k <= last; k++) {
        const v = line.points[k];
        if (v < low) { low = v; }
        if (v > high) { high = v; }
      }
    }
    if (!(low <= high)) { return [-1, 1]; }
    const room = 0.06 * (high - low) || Math.abs(high) * 0.1 || scale;
    return [(low - room) / scale, (high + room) / scale];
  }

  // where more than two points fall into a pixel column: its lowest and highest one, as bars where
  // a line would go up and down in most of them
  stroke(u, line, scale) {
    const { ctx, bbox } = u, [first, last] = this.shown(line), thick = 1.3 * devicePixelRatio;
    const x0 = u.valToPos(line.t0, "x", true), dx = u.valToPos(line.t0 + line.step, "x", true) - x0;
    const y0 = u.valToPos(0, "y", true), dy = (u.valToPos(1, "y", true) - y0) / scale;
    const x = k => x0 + k * dx, y = v => y0 + v * dy;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.strokeStyle = ctx.fillStyle = line.colour;
    const dense = last - first > 2 * bbox.width ? this.columns(line.points, first, last, x) : [];
    const tall = dense.reduce((sum, [, low, high]) => sum + y(low) - y(high), 0) > TALL * devicePixelRatio * dense.length;
    if (tall) {
      this.bars(dense, (top, bottom, column) => ctx.fillRect(column, y(top) - thick / 2, 1, y(bottom) - y(top) + thick));
    } else {
      ctx.beginPath();
      for (const [column, low, high, early] of dense) {
        ctx.lineTo(column + 0.5, y(early ? low : high));
        if (low !== high) { ctx.lineTo(column + 0.5, y(early ? high : low)); }
      }
      for (let k = first; k <= last && !dense.length; k++) {
        if (!Number.isFinite(line.points[k])) { continue; }
        if (k > first && !Number.isFinite(line.points[k - 1])) { ctx.moveTo(x(k), y(line.points[k])); } else { ctx.lineTo(x(k), y(line.points[k])); }
      }
      ctx.lineWidth = thick;
      ctx.lineJoin = "round";
      ctx.setLineDash(line.dash.map(length => length * devicePixelRatio));
      ctx.stroke();
    }
    ctx.restore();
  }

  // of every pixel column that has a point: lowest, highest, whether the lowest comes first
  columns(points, first, last, x) {
    const extremes = [];
    for (let k = first; k <= last;) {
      const column = Math.floor(x(k));
      let low = k, high = k;
      for (; k <= last && Math.floor(x(k)) === column; k++) {
        if (!(points[k] >= points[low])) { low = Number.isFinite(points[k]) ? k : low; }
        if (!(points[k] <= points[high])) { high = Number.isFinite(points[k]) ? k : high; }
      }
      if (Number.isFinite(points[low])) { extremes.push([column, points[low], points[high], low <= high]); }
    }
    return extremes;
  }

  // a bar for each column, which reaches to that of the column before
  bars(columns, draw) {
    columns.forEach(([column, low, high], k) => {
      const [before, under, over] = columns[k - 1] ?? [];
      const joined = before === column - 1;
      draw(joined ? Math.max(high, under) : high, joined ? Math.min(low, over) : low, column);
    });
  }

  zoom(range) {
    this.range = range;
    for (const { plot } of this.charts) { plot.setData([range, [0, 0]]); }
    this.cursor(this.time);
  }

  // all cursors to t, values beside them
  cursor(t) {
    this.time = t;
    for (const chart of this.charts) {
      const [begin, end] = this.range, inside = t >= begin && t <= end;
      // not by the plot's own scale: it follows a change of the range only later
      const left = (t - begin) / (end - begin) * chart.plot.over.clientWidth;
      chart.plot.setCursor({ left: inside ? left : -10, top: 1 }, false);
      chart.values.replaceChildren(...chart.lines.map(line => {
        const text = document.createElement("b");
        text.style.color = line.colour;
        text.textContent = `${line.label && `${line.label}: `}${shown(valueAt(line, t), line.unit)}`;
        return text;
      }));
    }
  }

  resize() { this.charts.forEach(({ plot }) => plot.setSize({ width: this.width, height: this.height })); }
}

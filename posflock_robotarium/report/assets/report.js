/* The page's own part: an arena that replays, curves that share its cursor. No library but uPlot. */
(() => {
"use strict";
const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);
const { colour, number } = look;
const { floats } = recorded;

/* ---------- runs, and the time that they share ---------- */
const runs = data.runs.map(recorded.decoded);
let run = runs[0];
const many = runs.length > 1;
const origin = () => (many ? run.start : 0); // several runs share a clock that starts with each experiment
const begin = () => (many ? 0 : run.t[0]);
const end = () => run.t[run.t.length - 1] - origin();
const frameAt = (time) => recorded.frameAt(run, time + origin());

/* ---------- time: one clock for arena, slider and curves ---------- */
const state = { time: begin(), playing: false, speed: 4, zoom: null };
const arena = $("arena"), scrub = $("scrub"), clock = $("clock"), play = $("play");
function seek(time, { from = null, speak = false } = {}) {
  state.time = Math.min(end(), Math.max(begin(), time));
  drawArena();
  const share = end() > begin() ? (state.time - begin()) / (end() - begin()) : 0;
  if (from !== scrub) scrub.value = String(Math.round(share * 1000));
  const words = `${state.time.toFixed(1)} s`;
  clock.textContent = words;
  scrub.setAttribute("aria-valuetext", `${words} of ${end().toFixed(1)} s`);
  moveCursors(from);
  showNow();
  if (speak) announce();
}
function announce() {
  const said = [`At ${state.time.toFixed(1)} seconds`];
  for (const item of nowItems()) said.push(`${item.label} ${item.text}`);
  $("spoken").textContent = said.join(", ");
  arena.setAttribute("aria-label", `The arena from above. ${said.join(", ")}.`);
}
let previous = 0;
function tick(stamp) {
  if (!state.playing) return;
  const passed = Math.min(0.25, (stamp - previous) / 1000);
  previous = stamp;
  const time = state.time + passed * state.speed;
  seek(time);
  if (time >= end()) setPlaying(false); else requestAnimationFrame(tick);
}
function setPlaying(on) {
  if (on && state.time >= end() - 1e-6) state.time = begin();
  state.playing = on;
  play.classList.toggle("on", on);
  play.setAttribute("aria-label", on ? "Pause" : "Play");
  if (on) { previous = performance.now(); requestAnimationFrame(tick); } else announce();
}

/* ---------- the arena ---------- */
const TRAIL = 12;
const sizeArena = () => arenaPicture.size(arena, run.arena);
function drawArena() {
  const poses = recorded.posesAt(run, state.time + origin()), frame = frameAt(state.time), first = frameAt(state.time - TRAIL), troubled = new Set();
  for (const event of run.events)
    if (state.time + origin() >= event.t - 0.05 && state.time + origin() <= Math.max(event.end, event.t + 0.4)) event.robots.forEach((i) => troubled.add(i));
  arenaPicture.draw(arena, colour, {
    arena: run.arena, poses, troubled, labels: $("labels").checked,
    lastSeen: (i) => recorded.lastSeen(run, frame, i),
    trails: $("trails").checked ? poses.map((pose, i) => recorded.trailOf(run, i, first, frame, pose)) : [],
    links: $("links").checked && run.radius.length ? recorded.linksAmong(run, poses) : [],
  });
}

/* ---------- curves ---------- */
const times = Float64Array.from(floats(data.time));
const plots = [];
let quiet = false; // while we move cursors and scales ourselves, their hooks stay silent
const tones = ["c0", "c1", "c2", "c3", "c4", "c5"];
const dashes = [[], [7, 3], [2, 3], [9, 3, 2, 3], [4, 2], [1, 2]];
const style = (k) => (k + Math.floor(k / 6)) % 6; // a seventh run has the first colour, but another dash
const faint = (hex) => `${hex}38`; // a band: its curve's colour, seen through

/* A null before each gap, so that no line is drawn across it. */
const breaks = data.gaps || [];
const axis = [], source = [], real = data.real_time ? floats(data.real_time) : null, realAxis = [];
{
  let next = 0;
  for (let k = 0; k < times.length; k++) {
    if (next < breaks.length && times[k] >= breaks[next] - 1e-3) {
      if (k) { axis.push((times[k - 1] + times[k]) / 2); source.push(-1); if (real) realAxis.push((real[k - 1] + real[k]) / 2); }
      while (next < breaks.length && times[k] >= breaks[next] - 1e-3) next++;
    }
    axis.push(times[k]); source.push(k);
    if (real) realAxis.push(real[k]);
  }
}
/* Over real time a stall is a gap, too: nobody knows what was between its ends. */
const stalls = [];
if (real) {
  const steps = Array.from(real.subarray(1), (time, k) => time - real[k]), usual = [...steps].sort((a, b) => a - b)[steps.length >> 1];
  steps.forEach((step, k) => { if (step > Math.max(0.5, 3 * usual)) stalls.push(k + 1); });
}
/* Curves are drawn over the log's own times or over real time; all else keeps the log's own. */
let drawn = axis;
function between(from, to, value) {
  if (from === to) return value;
  let low = 0, high = from.length - 1;
  while (low < high - 1) { const m = (low + high) >> 1; if (from[m] <= value) low = m; else high = m; }
  const length = from[high] - from[low];
  return length > 0 ? to[low] + ((value - from[low]) / length) * (to[high] - to[low]) : to[low];
}
const shownAt = (time) => between(axis, drawn, time);
const timeAt = (place) => between(drawn, axis, place);
const indexAt = (time) => {
  let low = 0, high = axis.length - 1;
  while (low < high) { const m = (low + high + 1) >> 1; if (axis[m] <= time + 1e-6) low = m; else high = m - 1; }
  return source[low] < 0 && low ? low - 1 : low;
};

function build(panel) {
  const raw = panel.series.map((series) => floats(series.values));
  const known = (values) => source.map((k) => (k < 0 || !isFinite(values[k]) ? null : values[k]));
  const columns = raw.map(known);
  // The ends of bands are curves that are not drawn, after those that are: upper, lower.
  const banded = panel.series.map((series, k) => (series.band ? k : -1)).filter((k) => k >= 0);
  const ends = banded.flatMap((k) => [known(floats(panel.series[k].band[1])), known(floats(panel.series[k].band[0]))]);
  const upper = (k) => 1 + columns.length + 2 * banded.indexOf(k);
  const figure = document.createElement("figure");
  const caption = document.createElement("figcaption");
  const title = document.createElement("span");
  title.textContent = panel.title;
  const unit = document.createElement("span");
  unit.className = "unit"; unit.textContent = [panel.unit, banded.length ? "shaded: 95 % band without tracking noise" : ""].filter(Boolean).join(", ");
  caption.append(title, unit);
  const legend = document.createElement("ul");
  legend.className = "legend";
  const values = panel.series.map((series, k) => {
    const item = document.createElement("li"), button = document.createElement("button"), value = document.createElement("b");
    button.type = "button"; button.setAttribute("aria-pressed", "true");
    const line = `<svg viewBox="0 0 22 6" aria-hidden="true"><line x1="0" y1="3" x2="22" y2="3" stroke="var(--${tones[series.look % 6]})" stroke-width="2.4" stroke-dasharray="${dashes[style(series.look)].join(" ")}"/></svg>`;
    button.insertAdjacentHTML("afterbegin", line);
    button.append(series.label, value);
    button.addEventListener("click", () => {
      const show = button.getAttribute("aria-pressed") !== "true";
      button.setAttribute("aria-pressed", String(show));
      plot.setSeries(k + 1, { show });
      if (series.band) for (const end of [upper(k), upper(k) + 1]) plot.setSeries(end, { show });
    });
    item.append(button); legend.append(item);
    return value;
  });
  const holder = document.createElement("div");
  holder.className = "plot"; holder.tabIndex = 0;
  holder.setAttribute("role", "img");
  holder.setAttribute("aria-label", `${panel.title}. ` + panel.series.map((s) => `${s.label}: mean ${number(s.extent[1])}, from ${number(s.extent[0])} to ${number(s.extent[2])} ${s.unit}`).join("; "));
  figure.append(caption, legend, holder);
  $("plots").append(figure);

  /* Where an angle jumps by a turn there is a null; a pixel that holds samples of both sides would join them all the same. */
  const broken = (u, column, first, last, gaps) => {
    const all = [...gaps], half = 2 * devicePixelRatio;
    if (column) for (let i = first; i <= last; i++) if (column[i] === null) { const x = u.valToPos(drawn[i], "x", true); all.push([x - half, x + half]); }
    if (drawn !== axis) for (const k of stalls) all.push([u.valToPos(real[k - 1], "x", true), u.valToPos(real[k], "x", true)]);
    all.sort((a, b) => a[0] - b[0]);
    return all.reduce((joined, gap) => { const end = joined[joined.length - 1]; if (end && gap[0] <= end[1]) end[1] = Math.max(end[1], gap[1]); else joined.push([...gap]); return joined; }, []);
  };
  const pen = () => colour.soft;
  const options = {
    width: Math.max(200, holder.clientWidth), height: 168,
    legend: { show: false },
    padding: [8, 8, 0, 0],
    scales: {
      x: { time: false },
      y: {
        range: (u, low, high) => {
          if (low === null) return [0, 1];
          for (const [value, , always] of panel.lines) if (always) { low = Math.min(low, value); high = Math.max(high, value); }
          if (panel.limits[0] !== null) low = Math.min(low, panel.limits[0]);
          if (panel.limits[1] !== null) high = Math.max(high, panel.limits[1]);
          const room = (high - low || Math.abs(high) || 1) * 0.06;
          return [panel.limits[0] !== null && low >= panel.limits[0] ? low : low - room, panel.limits[1] !== null ? high : high + room];
        },
      },
    },
    axes: [
      { stroke: pen, grid: { stroke: () => colour.line, width: 1 }, ticks: { show: false }, size: 26, font: "11.5px system-ui, sans-serif", values: (u, splits) => splits.map((v) => `${+v.toFixed(3)} s`) },
      { stroke: pen, grid: { stroke: () => colour.line, width: 1 }, ticks: { show: false }, size: 46, font: "11.5px system-ui, sans-serif", space: 26, values: (u, splits) => splits.map((v) => String(+v.toFixed(4)).replace("-", "−")) },
    ],
    cursor: { y: false, points: { size: 6, show: (u, k) => k <= columns.length && (() => { const dot = document.createElement("div"); dot.className = "u-cursor-pt"; return dot; })() }, drag: { x: true, y: false, setScale: true, dist: 6 }, bind: { dblclick: (u, target, handler) => (event) => { zoom(null); return null; } } },
    series: [{}, ...panel.series.map((series, k) => ({
      label: series.label, stroke: () => colour[tones[series.look % 6]], width: 1.7, dash: dashes[style(series.look)], spanGaps: false, points: { show: false },
      gaps: (u, k, first, last, gaps) => broken(u, series.unit === "rad" ? u.data[k] : null, first, last, gaps),
    })), ...ends.map(() => ({ width: 0, spanGaps: false, points: { show: false }, gaps: (u, k, first, last, gaps) => broken(u, null, first, last, gaps) }))],
    bands: banded.map((k) => ({ series: [upper(k), upper(k) + 1], fill: () => faint(colour[tones[panel.series[k].look % 6]]) })),
    hooks: {
      setCursor: [(u) => { if (!quiet && !state.playing && u.cursor.left >= 0) seek(timeAt(u.posToVal(u.cursor.left, "x")), { from: u }); }],
      setScale: [(u, key) => { if (!quiet && key === "x" && u.scales.x.min !== null) zoom([u.scales.x.min, u.scales.x.max], u); }],
      drawClear: [(u) => {
        const c = u.ctx;
        drawDrive(u, c);
        let right = u.bbox.left + u.bbox.width - 3; // labels of levels that are close stand side by side
        for (const [value, label] of panel.lines) {
          const y = u.valToPos(value, "y", true);
          if (y < u.bbox.top || y > u.bbox.top + u.bbox.height) continue;
          c.save(); c.strokeStyle = colour.bad; c.fillStyle = colour.bad; c.lineWidth = devicePixelRatio; c.setLineDash([3 * devicePixelRatio, 3 * devicePixelRatio]);
          c.beginPath(); c.moveTo(u.bbox.left, y); c.lineTo(u.bbox.left + u.bbox.width, y); c.stroke();
          c.font = `${11 * devicePixelRatio}px system-ui, sans-serif`; c.textAlign = "right"; c.textBaseline = "bottom";
          c.fillText(label, right, y - 2); right -= c.measureText(label).width + 9 * devicePixelRatio; c.restore();
        }
      }],
    },
  };
  const plot = new uPlot(options, [drawn, ...columns, ...ends], holder);
  plot.over.addEventListener("click", (event) => seek(timeAt(plot.posToVal(event.offsetX, "x")), { from: plot, speak: true }));
  plot.over.addEventListener("pointermove", (event) => { if (event.pointerType === "touch") seek(timeAt(plot.posToVal(event.offsetX, "x")), { from: plot }); });
  plots.push({ plot, holder, panel, columns, ends, values, band: (k, index) => (panel.series[k].band ? [ends[upper(k) - columns.length][index], ends[upper(k) - columns.length - 1][index]] : null) });
}
/* The drive to the start is no part of the experiment: its time is shaded. */
function drawDrive(u, c) {
  if (data.drive === null) return;
  const { left, top, width, height } = u.bbox, dot = devicePixelRatio;
  const from = Math.max(left, u.valToPos(drawn[0], "x", true)), to = Math.min(left + width, u.valToPos(shownAt(data.drive), "x", true));
  if (to <= from) return;
  c.save();
  c.globalAlpha = 0.6; c.fillStyle = colour.line; c.fillRect(from, top, to - from, height);
  c.globalAlpha = 1; c.fillStyle = colour.soft; c.font = `${11 * dot}px system-ui, sans-serif`;
  c.textAlign = "left"; c.textBaseline = "top"; // levels and their labels are mostly below
  c.fillText("drive to the start", from + 4 * dot, top + 3 * dot);
  c.restore();
}
function moveCursors(from) {
  const index = indexAt(state.time);
  quiet = true;
  for (const { plot, columns, values } of plots) {
    if (plot !== from) plot.setCursor({ left: plot.valToPos(shownAt(state.time), "x"), top: plot.bbox.height / devicePixelRatio / 2 }, false);
    columns.forEach((column, k) => { values[k].textContent = number(column[index]); });
  }
  quiet = false;
}
function zoom(range, from) {
  state.zoom = range && range[1] - range[0] < drawn[drawn.length - 1] - drawn[0] - 1e-6 ? range : null;
  quiet = true;
  for (const { plot } of plots)
    if (plot !== from) plot.setScale("x", { min: state.zoom ? range[0] : drawn[0], max: state.zoom ? range[1] : drawn[drawn.length - 1] });
  quiet = false;
  $("unzoom").hidden = !state.zoom;
  requestAnimationFrame(() => moveCursors(null));
}

/* ---------- what holds at this instant ---------- */
function nowItems() {
  if (many) return [];
  const index = indexAt(state.time), items = [];
  for (const { key, label, unit } of data.beside_replay)
    for (const { panel, columns, band } of plots)
      panel.series.forEach((series, k) => {
        if (series.key === key) {
          const value = columns[k][index], ends = band(k, index);
          const sure = ends && ends[0] !== null ? `${number(ends[0])} to ${number(ends[1])}` : "";
          items.push({ label, sure, text: value === null ? "undefined" : `${number(value)} ${unit}`.trim() });
        }
      });
  return items;
}
const nowList = $("now");
function showNow() {
  const items = nowItems();
  if (nowList.childElementCount !== items.length)
    nowList.replaceChildren(...items.map(() => { const d = document.createElement("div"); d.append(document.createElement("dt"), document.createElement("dd")); return d; }));
  items.forEach((item, k) => {
    nowList.children[k].children[0].textContent = item.label;
    nowList.children[k].children[1].textContent = item.text;
    if (item.sure) { const sure = document.createElement("span"); sure.className = "sure"; sure.textContent = item.sure; sure.title = "95 % band without tracking noise"; nowList.children[k].children[1].append(sure); }
  });
}

/* ---------- hands and keys ---------- */
play.addEventListener("click", () => setPlaying(!state.playing));
scrub.addEventListener("input", () => seek(begin() + (scrub.value / 1000) * (end() - begin()), { from: scrub }));
scrub.addEventListener("change", announce);
$("speed").addEventListener("change", (event) => { state.speed = Number(event.target.value); });
for (const id of ["trails", "links", "labels"]) $(id).addEventListener("change", drawArena);
if ($("axis")) $("axis").addEventListener("change", (event) => {
  drawn = event.target.value === "real" ? realAxis : axis;
  const time = state.time;
  quiet = true; // plots move their cursors once they are drawn again, which is no wish to go there
  for (const { plot, columns, ends } of plots) plot.setData([drawn, ...columns, ...ends]);
  requestAnimationFrame(() => { zoom(null); seek(time); });
});
$("unzoom").addEventListener("click", () => zoom(null));
$("theme").addEventListener("click", () => { look.turn(); repaint(); });
look.dark.addEventListener("change", repaint);
for (const button of document.querySelectorAll("[data-seek]"))
  button.addEventListener("click", () => { seek(Number(button.dataset.seek), { speak: true }); $("replay").scrollIntoView({ behavior: "smooth" }); });
if ($("run")) $("run").addEventListener("change", (event) => { run = runs[Number(event.target.value)]; marks(); sizeArena(); seek(state.time, { speak: true }); });

function nudge(seconds) { seek(state.time + seconds, { speak: true }); }
function frames(count) {
  const frame = Math.min(run.t.length - 1, Math.max(0, frameAt(state.time + 1e-4) + count));
  seek(run.t[frame] - origin(), { speak: true });
}
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const tag = event.target.tagName, editing = tag === "SELECT" || (tag === "INPUT" && event.target.type !== "checkbox" && event.target !== scrub);
  if (editing) return;
  const pressable = tag === "BUTTON" || tag === "SUMMARY" || tag === "A" || (tag === "INPUT" && event.target.type === "checkbox");
  const far = event.shiftKey ? 10 : 1;
  const speed = $("speed");
  const faster = (by) => { speed.selectedIndex = Math.min(speed.length - 1, Math.max(0, speed.selectedIndex + by)); state.speed = Number(speed.value); };
  const actions = {
    " ": () => setPlaying(!state.playing), k: () => setPlaying(!state.playing),
    ArrowLeft: () => nudge(-far), ArrowRight: () => nudge(far),
    ",": () => frames(-1), ".": () => frames(1),
    Home: () => seek(begin(), { speak: true }), End: () => seek(end(), { speak: true }),
    "+": () => faster(1), "=": () => faster(1), "-": () => faster(-1), r: () => zoom(null),
  };
  if (!(event.key in actions) || (event.key === " " && pressable)) return;
  event.preventDefault();
  actions[event.key]();
});

/* ---------- putting it together ---------- */
function marks() {
  const bar = $("marks"), length = end() - begin() || 1;
  const mark = (time, kind) => { const i = document.createElement("i"); i.className = kind; i.style.left = `${(100 * (time - origin() - begin())) / length}%`; return i; };
  bar.replaceChildren(...run.events.map((event) => mark(event.t, "fault")), ...(many ? [] : breaks.map((time) => mark(time, "gap"))));
}
function repaint() { look.apply(); for (const { plot } of plots) plot.redraw(false, true); drawArena(); }
function resize() {
  sizeArena();
  for (const { plot, holder } of plots) plot.setSize({ width: Math.max(200, holder.clientWidth), height: 168 });
  seek(state.time);
}
/* On paper all sections are open, everything is light, and curves are drawn for the width they get there. */
const PRINTED = 480;
let before = null;
addEventListener("beforeprint", () => {
  if (before) return;
  const closed = [...document.querySelectorAll("details:not([open])")];
  before = { closed, chosen: look.chosen };
  for (const section of closed) section.open = true;
  look.chosen = "light";
  repaint();
  for (const { plot } of plots) plot.setSize({ width: PRINTED, height: 168 });
});
addEventListener("afterprint", () => {
  if (!before) return;
  for (const section of before.closed) section.open = false;
  look.chosen = before.chosen;
  before = null;
  repaint();
  resize();
});
data.panels.forEach(build);
marks();
sizeArena();
seek(begin());
announce();
let waiting = 0, width = innerWidth;
addEventListener("resize", () => { if (innerWidth === width) return; width = innerWidth; cancelAnimationFrame(waiting); waiting = requestAnimationFrame(resize); });
globalThis.posflock = { state, seek, get run() { return run; } };
})();

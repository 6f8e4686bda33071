/* The live page: shows what comes through the websocket, asks what its controls say. */
(() => {
"use strict";
const $ = (id) => document.getElementById(id);
const { colour, number } = look;
const TRAIL = 12; // s
const SENT_APART = 120; // ms between two requests of a slider that moves
const state = { hello: null, scene: null, frame: null, past: [], settings: null, flock: null, phase: "connecting", outcome: null, wished: null };
let socket = null;

/* ---------- the line to the server ---------- */
function connect() {
  const address = new URL("live", location.href);
  address.protocol = "ws:";
  socket = new WebSocket(address);
  socket.onopen = () => { $("lost").hidden = true; };
  socket.onmessage = (event) => {
    let message;
    try { message = JSON.parse(event.data); } catch { return; }
    if (message.kind in hear) hear[message.kind](message.data);
  };
  socket.onclose = () => {
    $("lost").textContent = "The server does not answer: posflock watch has ended, or the connection is lost. This page tries again every two seconds.";
    $("lost").hidden = false;
    state.phase = "lost";
    showPhase();
    setTimeout(connect, 2000);
  };
}
function ask(request) { if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(request)); }

const hear = {
  hello(data) {
    state.hello = data;
    $("script").textContent = data.script;
    document.title = `${data.script} – posflock watch`;
    fill($("profile"), data.profiles.map((name) => [name, name]));
    fill($("speed"), data.speeds.map((speed) => [String(speed), speed === null ? "max" : `${speed} ×`]));
    buildLaw(data);
  },
  begin() {
    Object.assign(state, { scene: null, frame: null, past: [], flock: null, wished: null });
    $("printed").textContent = "";
    $("barrier").textContent = "No certificate has been asked yet.";
    $("active").replaceChildren();
    $("now").replaceChildren();
  },
  scene(data) { state.scene = data; state.past = []; size(); showFacts(); },
  past(frames) {
    state.past = [];
    for (const frame of frames) remember(frame);
    if (frames.length) hear.frame(frames[frames.length - 1], true);
  },
  frame(data, known = false) {
    state.frame = data;
    if (!known) remember(data);
    requestAnimationFrame(draw);
    showNow();
  },
  state(data) {
    const before = state.phase, paused = state.settings && state.settings.paused;
    Object.assign(state, { settings: data.settings, flock: data.flock, phase: data.phase, outcome: data.outcome });
    if (data.refused) say(data.refused);
    if (data.refused || data.flock?.model === state.wished) state.wished = null;
    showControls();
    showPhase();
    showOutcome();
    if (state.frame) showNow();
    if (before !== data.phase || paused !== data.settings.paused) say(`${$("phase").textContent}${state.frame ? `, at ${state.frame.time.toFixed(1)} seconds` : ""}`);
  },
  printed(text) {
    const box = $("printed"), below = box.scrollHeight - box.scrollTop - box.clientHeight < 40;
    box.textContent = (box.textContent + text).slice(-20000);
    if (below) box.scrollTop = box.scrollHeight;
  },
  refused(text) { say(text); },
};

/* ---------- the arena ---------- */
function remember(frame) {
  const x = frame.poses[0], y = frame.poses[1];
  state.past.push({ time: frame.time, points: x.map((value, i) => (value === null ? null : [value, y[i]])) });
  while (state.past.length && state.past[0].time < frame.time - TRAIL) state.past.shift();
}
const size = () => { if (state.scene) { arenaPicture.size($("arena"), state.scene.arena); draw(); } };
function draw() {
  const { frame, scene } = state;
  if (!frame || !scene) return;
  const [x, y, heading] = frame.poses, barrier = $("barriers").checked ? frame.barrier : null;
  arenaPicture.draw($("arena"), colour, {
    arena: scene.arena,
    poses: x.map((value, i) => (value === null ? null : [value, y[i], heading[i]])),
    trails: $("trails").checked ? x.map((_, i) => state.past.map((past) => past.points[i])) : [],
    links: $("links").checked ? frame.links : [],
    pairs: barrier ? barrier.pairs : [],
    held: new Set(barrier ? barrier.held : []),
    arrows: barrier ? barrier.held.map((robot, k) => [robot, [barrier.asked[0][k], barrier.asked[1][k]], [barrier.given[0][k], barrier.given[1][k]]]) : [],
    troubled: new Set(frame.faults.flatMap((fault) => fault.robots)),
    leds: frame.leds,
    labels: $("labels").checked,
  });
}

/* ---------- words and numbers ---------- */
function say(text) { $("spoken").textContent = text; }
function showPhase() {
  const paused = state.phase === "running" && state.settings.paused;
  const ended = state.phase === "ended" && state.outcome;
  const driving = state.phase === "running" && Boolean(state.frame?.driving_to_start);
  const drive = driving ? "driving to the start" : "";
  const word = paused ? ["paused", drive].filter(Boolean).join(", ") : ended ? state.outcome.ended : state.phase === "lost" ? "no connection" : drive || state.phase;
  const bad = state.phase === "lost" || (ended && state.outcome.exit_code !== 0);
  if ($("phase").textContent !== word) $("phase").textContent = word;
  $("phase").className = `phase ${bad ? "bad" : paused ? "paused" : driving ? "driving" : state.phase}`;
}
function showFacts() {
  const { hello, scene } = state;
  if (!hello || !scene) return;
  const seed = hello.seed === null ? "no seed" : `seed ${hello.seed}`;
  $("facts").textContent = `${scene.robots} robots · generation ${hello.generation} · ${seed} · steps of ${1000 * scene.time_step} ms`;
}
function items() {
  const { frame } = state, found = [], barrier = frame.barrier;
  if (frame.gamma) found.push(["γ from headings", number(frame.gamma.headings)], ["γ from motion", number(frame.gamma.motion)]);
  const speeds = frame.commands[0].filter((speed) => speed !== null).map(Math.abs);
  found.push(["fastest command", `${number(Math.max(...speeds))} m/s`]);
  if (barrier) {
    found.push(["changed by", barrier.intervention === null ? "unknown" : `${number(barrier.intervention)} m/s`]);
    found.push(["clearance", barrier.clearance === null ? "unknown" : `${number(1000 * barrier.clearance)} mm`]);
  }
  found.push(["pairs too close", String(frame.collisions)], ["steps outside", String(frame.outside)]);
  return found;
}
function showNow() {
  const { frame } = state, list = $("now"), found = items();
  $("clock").textContent = `${frame.time.toFixed(1)} s`;
  const running = state.phase === "running" && !state.settings.paused;
  $("beside-clock").textContent = !running ? `step ${frame.step}` : frame.reached === null ? "" : `runs at ${number(frame.reached)} ×`;
  $("links-label").hidden = !frame.links;
  showPhase();
  showLegend();
  if (list.childElementCount !== found.length)
    list.replaceChildren(...found.map(() => { const d = document.createElement("div"); d.append(document.createElement("dt"), document.createElement("dd")); return d; }));
  found.forEach(([label, text], k) => {
    list.children[k].children[0].textContent = label;
    list.children[k].children[1].textContent = text;
  });
  showBarrier(frame.barrier);
  const words = found.map(([label, text]) => `${label} ${text}`).join(", ");
  $("arena").setAttribute("aria-label", `The arena from above at ${frame.time.toFixed(1)} s: ${words}.`);
}
/* Of what is drawn now. */
function showLegend() {
  for (const item of document.querySelectorAll("#legend [data-of]")) {
    const { of } = item.dataset;
    item.hidden = !$(of).checked || (of === "links" && !state.frame?.links) || (of === "barriers" && !state.frame?.barrier);
  }
}
function showBarrier(barrier) {
  if (!barrier) return;
  const robots = barrier.held.length === 1 ? "1 robot is" : `${barrier.held.length} robots are`;
  const words = { trivial: "Every command is safe as it is.", optimal: `${robots} held back.`, relaxed: `No velocity keeps everybody safe: ${robots} held back as well as can be.`, failed: "The robots are stopped." };
  const text = barrier.status === "optimal" && !barrier.held.length ? words.trivial : words[barrier.status] || barrier.status;
  if ($("barrier").textContent !== text) $("barrier").textContent = text;
  $("active").replaceChildren(...barrier.active.slice(0, 8).map((what) => { const item = document.createElement("li"); item.textContent = what; return item; }));
}
function showOutcome() {
  const box = $("outcome"), { outcome } = state;
  box.hidden = !outcome;
  if (!outcome) return;
  box.className = outcome.exit_code !== 0 ? "bad" : outcome.clean ? "good" : "caution";
  const verb = { finished: "has finished", failed: "has failed", interrupted: "was interrupted", hung: "waits for ever", died: "has died" }[outcome.ended];
  $("h-outcome").textContent = `The script ${verb || `ended: ${outcome.ended}`}`;
  $("reason").textContent = outcome.reason;
  $("lines").replaceChildren(...outcome.lines.map((line) => { const item = document.createElement("li"); item.textContent = line.trim(); return item; }));
}

/* ---------- controls show what is so, and ask for what is wanted ---------- */
function fill(select, options) {
  select.replaceChildren(...options.map(([value, text]) => { const option = document.createElement("option"); option.value = value; option.textContent = text; return option; }));
}
function buildLaw({ ranges, models }) {
  $("sliders").replaceChildren(...Object.entries(ranges).map(([name, span]) => {
    const row = document.createElement("div"), label = document.createElement("label"), symbol = document.createElement("b"), input = document.createElement("input"), value = document.createElement("output");
    row.className = "slider";
    symbol.textContent = span.symbol;
    label.append(symbol, ` ${span.label}`);
    label.htmlFor = input.id = value.htmlFor = `law-${name}`;
    Object.assign(input, { type: "range", min: span.least, max: span.most, step: span.step });
    value.id = `value-${name}`;
    const told = () => { value.textContent = `${Number(input.value)} ${span.unit}`; input.setAttribute("aria-valuetext", value.textContent); };
    let due = 0;
    const send = () => { due = 0; ask({ do: "law", [name]: Number(input.value) }); };
    input.addEventListener("input", () => { told(); if (!due) due = setTimeout(send, SENT_APART); });
    input.addEventListener("change", () => { clearTimeout(due); send(); });
    input.told = told;
    input.moves = () => due !== 0;
    row.append(label, input, value);
    return row;
  }));
  $("models").replaceChildren(...Object.entries(models).map(([name, words]) => {
    const label = document.createElement("label"), input = document.createElement("input");
    Object.assign(input, { type: "radio", name: "model", value: name });
    input.addEventListener("change", () => { state.wished = name; ask({ do: "law", model: name }); });
    label.append(input, words);
    return label;
  }));
}
function showControls() {
  const { settings, flock, hello, phase } = state, play = $("play");
  const running = phase === "running" || phase === "starting", going = running && !settings.paused;
  play.classList.toggle("on", going);
  play.setAttribute("aria-label", going ? "Pause" : "Go on");
  play.disabled = $("step").disabled = !running;
  $("profile").value = settings.profile;
  $("speed").value = String(settings.speed);
  $("law").hidden = !flock;
  if (!flock || !hello) return;
  for (const [name, span] of Object.entries(hello.ranges)) {
    const input = $(`law-${name}`), value = flock[name], one = typeof value === "number";
    input.disabled = !one; // one value a robot: nothing to slide
    if (one && !input.moves()) { input.value = value; input.told(); if (Math.abs(Number(input.value) - value) > span.step / 100) $(`value-${name}`).textContent = `${number(value)} ${span.unit}`; }
    if (!one) $(`value-${name}`).textContent = "per robot";
  }
  const model = state.wished ?? flock.model; // an answer to an earlier request does not undo the click
  for (const input of document.querySelectorAll("#models input")) input.checked = input.value === model;
}
const toggle = () => { if (!$("play").disabled) ask({ do: state.settings?.paused ? "go" : "pause" }); };
const step = () => { if (!$("step").disabled) ask({ do: "step", steps: 1 }); };
function faster(by) {
  const select = $("speed"), index = Math.min(select.length - 1, Math.max(0, select.selectedIndex + by));
  if (index !== select.selectedIndex) { select.selectedIndex = index; setSpeed(); }
}
const setSpeed = () => ask({ do: "speed", factor: JSON.parse($("speed").value) });
$("play").addEventListener("click", toggle);
$("step").addEventListener("click", step);
$("again").addEventListener("click", () => ask({ do: "again" }));
$("speed").addEventListener("change", setSpeed);
$("profile").addEventListener("change", (event) => ask({ do: "profile", name: event.target.value }));
for (const id of ["trails", "links", "barriers", "labels"]) $(id).addEventListener("change", () => { draw(); showLegend(); });
$("theme").addEventListener("click", () => { look.turn(); repaint(); });
look.dark.addEventListener("change", repaint);
function repaint() { look.apply(); draw(); }
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const tag = event.target.tagName, type = event.target.type;
  if (tag === "SELECT" || (tag === "INPUT" && type !== "checkbox" && type !== "range")) return;
  const pressable = ["BUTTON", "SUMMARY", "A"].includes(tag) || type === "checkbox";
  const actions = { " ": toggle, ".": step, "+": () => faster(1), "=": () => faster(1), "-": () => faster(-1) };
  if (!(event.key in actions) || (event.key === " " && pressable)) return;
  event.preventDefault();
  actions[event.key]();
});
let waiting = 0;
addEventListener("resize", () => { cancelAnimationFrame(waiting); waiting = requestAnimationFrame(size); });
connect();
globalThis.posflock = { state, ask };
})();

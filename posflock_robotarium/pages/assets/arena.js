/* The arena from above, as the report's replay and the live page draw it. */
const arenaPicture = (() => {
"use strict";
const PAD = 0.07; // m around the arena
const shape = ([left, right, bottom, top]) => [right - left + 2 * PAD, top - bottom + 2 * PAD];

/* Give a canvas the height of an arena, and the pixels of the screen. */
function size(canvas, arena) {
  const width = canvas.clientWidth, [wide, high] = shape(arena), scale = window.devicePixelRatio || 1;
  canvas.style.height = `${Math.round((width * high) / wide)}px`;
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(((width * high) / wide) * scale);
}

/* Draw what is seen:
   arena                 left, right, bottom, top, m
   poses                 of each robot x, y, heading; null where it is not seen
   lastSeen(i)           its last pose then; null where there is none
   trails                of each robot points x, y, the oldest first; null breaks the line
   links, pairs          robots that are neighbours; that are kept apart from each other
   troubled, held        sets of robots at fault; that a certificate holds back
   arrows                of held robots: robot, velocity asked for, velocity given, m/s
   leds                  of each robot a colour; null where it is off
   labels                whether robots are numbered */
function draw(canvas, colour, view) {
  const c = canvas.getContext("2d"), [left, right, bottom, top] = view.arena;
  const scale = canvas.width / shape(view.arena)[0], thin = Math.max(1, scale * 0.003);
  const to = { scale, thin, X: (x) => (x - left + PAD) * scale, Y: (y) => (top + PAD - y) * scale };
  c.setTransform(1, 0, 0, 1, 0, 0);
  c.fillStyle = colour.arena;
  c.fillRect(0, 0, canvas.width, canvas.height);
  c.lineWidth = thin; c.strokeStyle = colour.grid;
  c.beginPath();
  for (let x = Math.ceil(left * 2) / 2; x <= right; x += 0.5) { c.moveTo(to.X(x), to.Y(bottom)); c.lineTo(to.X(x), to.Y(top)); }
  for (let y = Math.ceil(bottom * 2) / 2; y <= top; y += 0.5) { c.moveTo(to.X(left), to.Y(y)); c.lineTo(to.X(right), to.Y(y)); }
  c.stroke();
  c.lineWidth = 2 * thin; c.strokeStyle = colour.wall;
  c.strokeRect(to.X(left), to.Y(top), (right - left) * scale, (top - bottom) * scale);
  (view.trails || []).forEach((trail) => drawTrail(c, colour, to, trail));
  drawLines(c, to, view.poses, view.links, colour.link, 1.4);
  drawLines(c, to, view.poses, view.pairs, colour.caution, 3);
  drawRobots(c, colour, to, view, top);
  drawArrows(c, colour, to, view);
}

/* Three pieces, fainter the older, so that a trail tells its direction. */
function drawTrail(c, colour, to, points) {
  c.lineWidth = 2.2 * to.thin; c.lineJoin = "round"; c.strokeStyle = colour.robot;
  for (let piece = 0; piece < 3; piece++) {
    const from = Math.floor((points.length * piece) / 3), end = Math.floor((points.length * (piece + 1)) / 3);
    c.globalAlpha = 0.14 + 0.16 * piece;
    c.beginPath();
    let open = false;
    for (const point of points.slice(from, end + 1)) {
      if (!point) open = false;
      else if (open) c.lineTo(to.X(point[0]), to.Y(point[1]));
      else { c.moveTo(to.X(point[0]), to.Y(point[1])); open = true; }
    }
    c.stroke();
  }
  c.globalAlpha = 1;
}

function drawLines(c, to, poses, pairs, colour, width) {
  if (!pairs || !pairs.length) return;
  c.lineWidth = width * to.thin; c.strokeStyle = colour;
  c.beginPath();
  for (const [i, j] of pairs) {
    const a = poses[i], b = poses[j];
    if (a && b) { c.moveTo(to.X(a[0]), to.Y(a[1])); c.lineTo(to.X(b[0]), to.Y(b[1])); }
  }
  c.stroke();
}

function drawRobots(c, colour, to, view, top) {
  const { scale, thin, X, Y } = to, held = view.held || new Set();
  c.font = `600 ${Math.round(0.075 * scale)}px system-ui, sans-serif`;
  c.textAlign = "center"; c.textBaseline = "middle";
  const name = (i, x, y) => { if (view.labels) c.fillText(String(i), X(x), Y(y + (y > top - 0.2 ? -0.115 : 0.115))); };
  view.poses.forEach((pose, i) => {
    const seen = pose || (view.lastSeen && view.lastSeen(i));
    if (!seen) return;
    const [x, y, heading] = seen;
    if (!pose) { // where it was last seen, as an outline
      c.lineWidth = 2 * thin; c.strokeStyle = colour.soft; c.setLineDash([4 * thin, 4 * thin]);
      c.strokeRect(X(x - 0.055), Y(y + 0.055), 0.11 * scale, 0.11 * scale);
      c.setLineDash([]);
      c.fillStyle = colour.soft;
      c.fillText("?", X(x), Y(y));
      name(i, x, y);
      return;
    }
    c.save();
    c.translate(X(x), Y(y)); c.rotate(-heading); c.scale(scale, scale);
    c.fillStyle = view.troubled.has(i) ? colour.bad : colour.robot;
    c.beginPath(); c.roundRect(-0.05, -0.055, 0.1, 0.11, 0.018); c.fill();
    if (held.has(i)) { c.lineWidth = 0.012; c.strokeStyle = colour.caution; c.beginPath(); c.arc(0, 0, 0.088, 0, 2 * Math.PI); c.stroke(); }
    c.fillStyle = colour.mark;
    c.beginPath(); c.moveTo(0.041, 0); c.lineTo(-0.03, 0.036); c.lineTo(-0.013, 0); c.lineTo(-0.03, -0.036); c.closePath(); c.fill();
    const led = view.leds && view.leds[i];
    if (led) { c.fillStyle = led; c.strokeStyle = colour.mark; c.lineWidth = 0.005; c.beginPath(); c.arc(-0.036, 0, 0.016, 0, 2 * Math.PI); c.fill(); c.stroke(); }
    c.restore();
    c.fillStyle = colour.ink;
    name(i, x, y);
  });
}

/* Where a held robot would have gone within a second, dashed, and where it may go. */
function drawArrows(c, colour, to, view) {
  for (const [robot, asked, given] of view.arrows || []) {
    const pose = view.poses[robot];
    if (!pose) continue;
    for (const [velocity, stroke, dash] of [[asked, colour.bad, [5, 4]], [given, colour.ink, []]]) {
      const length = Math.hypot(...velocity);
      if (length < 0.004) continue;
      const x = to.X(pose[0]), y = to.Y(pose[1]), ex = to.X(pose[0] + velocity[0]), ey = to.Y(pose[1] + velocity[1]);
      const turn = Math.atan2(ey - y, ex - x), tip = 0.03 * to.scale;
      c.lineWidth = 2 * to.thin; c.strokeStyle = stroke;
      c.setLineDash(dash.map((part) => part * to.thin));
      c.beginPath(); c.moveTo(x, y); c.lineTo(ex, ey); c.stroke();
      c.setLineDash([]);
      c.beginPath(); c.moveTo(ex - tip * Math.cos(turn - 0.5), ey - tip * Math.sin(turn - 0.5)); c.lineTo(ex, ey); c.lineTo(ex - tip * Math.cos(turn + 0.5), ey - tip * Math.sin(turn + 0.5)); c.stroke();
    }
  }
}
return { size, draw };
})();

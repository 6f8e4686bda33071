/* A run as it was recorded: its poses, quantised in the page, turned back when asked for. Times are its log's own. */
const recorded = (() => {
"use strict";
const bytes = (b64) => Uint8Array.from(atob(b64), (c) => c.charCodeAt(0)).buffer;
const floats = (b64) => new Float32Array(bytes(b64));
const decoded = (run) => ({ ...run, t: floats(run.t), q: new Uint16Array(bytes(run.poses)) });

function frameAt(run, time) {
  let low = 0, high = run.t.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (run.t[middle] <= time) low = middle; else high = middle - 1;
  }
  return low;
}
function poseOf(run, frame, robot) {
  const n = run.robots, base = frame * 3 * n;
  if (run.q[base + robot] === 65535) return null; // not seen
  return [
    run.low[0] + (run.q[base + robot] / 65534) * run.span[0],
    run.low[1] + (run.q[base + n + robot] / 65534) * run.span[1],
    (run.q[base + 2 * n + robot] / 65534) * 2 * Math.PI,
  ];
}
function lastSeen(run, frame, robot) {
  for (let k = frame; k >= 0; k--) {
    const pose = poseOf(run, k, robot);
    if (pose) return pose;
  }
  return null;
}
/* Between two frames robots move in a straight line, unless a gap lies between. */
function posesAt(run, time) {
  const frame = frameAt(run, time), next = Math.min(frame + 1, run.t.length - 1);
  const length = run.t[next] - run.t[frame];
  let share = length > 0 ? Math.min(1, Math.max(0, (time - run.t[frame]) / length)) : 0;
  if (length > 0.5) share = 0;
  const poses = [];
  for (let i = 0; i < run.robots; i++) {
    const a = poseOf(run, frame, i), b = share > 0 ? poseOf(run, next, i) : null;
    if (a && b) {
      const turn = Math.atan2(Math.sin(b[2] - a[2]), Math.cos(b[2] - a[2]));
      poses.push([a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * turn]);
    } else poses.push(a);
  }
  return poses;
}
/* A null where nobody knows how it went on. */
function trailOf(run, robot, first, frame, pose) {
  const points = [], step = Math.max(1, Math.floor((frame - first) / 120));
  let when = run.t[first];
  for (let k = first; k <= frame; k += step) {
    const p = poseOf(run, k, robot);
    if (!p || run.t[k] - when >= 0.5 * step) points.push(null); // nobody knows how it went there
    if (p) { points.push(p); when = run.t[k]; }
  }
  if (pose && points[points.length - 1]) points.push(pose);
  return points;
}
/* Who is within reach of whom. */
function linksAmong(run, poses) {
  const links = [];
  for (let i = 0; i < run.robots; i++)
    for (let j = i + 1; j < run.robots; j++)
      if (poses[i] && poses[j] && Math.hypot(poses[i][0] - poses[j][0], poses[i][1] - poses[j][1]) < Math.max(run.radius[i], run.radius[j])) links.push([i, j]);
  return links;
}
return { floats, decoded, frameAt, lastSeen, posesAt, trailOf, linksAmong };
})();

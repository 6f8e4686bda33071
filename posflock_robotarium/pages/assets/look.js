/* What the project's pages share: light or dark, the colours of either, how numbers are written. */
const look = (() => {
"use strict";
const dark = matchMedia("(prefers-color-scheme: dark)");
const shared = { chosen: null, colour: {}, dark };
const names = ["arena", "wall", "grid", "link", "robot", "mark", "ink", "soft", "line", "bad", "caution", "accent", "c0", "c1", "c2", "c3", "c4", "c5"];

shared.apply = () => {
  document.documentElement.dataset.theme = shared.chosen || (dark.matches ? "dark" : "light");
  const style = getComputedStyle(document.documentElement);
  for (const name of names) shared.colour[name] = style.getPropertyValue("--" + name).trim();
};
shared.turn = () => { shared.chosen = document.documentElement.dataset.theme === "dark" ? "light" : "dark"; };
shared.number = (value, digits = 3) => {
  if (value === null || value === undefined || !isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e5 || size < 1e-4 ? value.toExponential(1) : value.toFixed(Math.max(0, Math.min(4, digits - 1 - Math.floor(Math.log10(size)))));
  return text.replace("-", "−");
};
shared.apply();
return shared;
})();

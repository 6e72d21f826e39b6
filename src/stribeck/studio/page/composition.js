// The picture of an axis: its parts in the order in which power flows, and the same in words.

import { h, t } from "./dom.js";

const ROLES = ["controller", "motor", "transmission", "load", "sensor"];
const SPACE = "http://www.w3.org/2000/svg";
const GAP = 34;
const NARROW = 640;

function s(tag, attributes = {}, ...children) {
  const element = document.createElementNS(SPACE, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

const path = (d, more = {}) => s("path", { d, ...more });
const letters = (text) => s("text", { x: 0, y: 5, class: "glyph-text" }, text);
const GROUND = path("M-24 16 H24 M-20 16 l-5 6 M-8 16 l-5 6 M4 16 l-5 6 M16 16 l-5 6");
const SPRING = "M-26 0 h6 l4 -8 l8 16 l8 -16 l8 16 l4 -8 h6";

// What stands for a part, around the origin, 60 by 44; a part without one is its letters.
const GLYPHS = {
  "controller none": () => [path("M-22 0 H22", { "stroke-dasharray": "4 4" })],
  controller: (name) => [letters({ pd: "PD", p: "P", damped: "P, −v", cascade: "P–PI", pwm: "PWM" }[name] ?? name)],
  motor: (name) => [s("circle", { r: 18 }), letters(name === "measured" ? "F" : "M")],
  "transmission rigid": () => [path("M-26 0 H26 M-26 -6 V6 M26 -6 V6")],
  "transmission gear": () => [s("circle", { cx: -12, r: 8 }), s("circle", { cx: 11, r: 15 }), path("M-26 0 H-12 M11 0 H28")],
  "transmission screw": () => [path("M-28 0 H28 M-24 -7 l6 14 M-15 -7 l6 14 M-6 -7 l6 14 M3 -7 l6 14 M12 -7 l6 14"), s("rect", { x: -10, y: -13, width: 20, height: 26 })],
  transmission: () => [path(SPRING)],
  "load pendulum": () => [path("M-8 -18 H8 M0 -18 L12 10"), s("circle", { cx: 14, cy: 14, r: 7, class: "solid" })],
  "load inertia": () => [s("circle", { r: 16 }), s("circle", { r: 2, class: "solid" }), path("M-8 -8 A 11 11 0 0 1 10 -5 l-5 -1 m5 1 l1 -5")],
  "load spring": () => [path(SPRING), path("M26 -12 V12 M26 -8 l5 -5 M26 0 l5 -5 M26 8 l5 -5")],
  load: () => [s("rect", { x: -16, y: -10, width: 32, height: 26 }), GROUND.cloneNode(true)],
  sensor: () => [path("M-24 10 H24 V-2 H-24 Z M-16 10 v-6 M-8 10 v-4 M0 10 v-6 M8 10 v-4 M16 10 v-6 M4 -14 l-4 8 l-4 -8 z")],
};

function box({ role, name }, x, y, width, height, amber) {
  const glyph = GLYPHS[`${role} ${name}`] ?? GLYPHS[role] ?? (() => []);
  return s("g", { class: amber ? "block amber" : "block", transform: `translate(${x} ${y})` },
    s("rect", { width, height, rx: 8, class: "frame" }),
    s("text", { x: width / 2, y: 18, class: "role" }, t(`role.${role}`)),
    s("g", { class: "glyph", transform: `translate(${width / 2} ${height / 2})` }, ...glyph(name)),
    s("text", { x: width / 2, y: height - 9, class: "name" }, name));
}

const arrow = (d) => path(d, { class: "arrow", "marker-end": "url(#arrow-head)" });

function draw(blocks, amber, full) {
  const columns = ROLES.map((role) => blocks.filter((block) => block.role === role)).filter((column) => column.length);
  const upright = full < NARROW;
  const deepest = Math.max(...columns.map((column) => column.length));
  const loop = blocks.some(({ role, name }) => role === "controller" && name !== "none");
  const height = 92;
  const step = height + 14;
  const width = upright ? Math.min(150, (full - GAP - 14 * (deepest - 1)) / deepest) : Math.min(170, (full - GAP * columns.length) / columns.length);
  const parts = [];
  columns.forEach((column, k) => column.forEach((block, i) => {
    const x = upright ? GAP + i * (width + 14) : GAP + k * (width + GAP);
    const y = upright ? GAP + k * (height + GAP) : 4 + i * step;
    parts.push(box(block, x, y, width, height, amber(block)));
    if (i > 0 || (k === 0 && !loop)) return;
    const [cx, cy] = [x + width / 2, y + height / 2];
    parts.push(arrow(upright ? `M${cx} ${y - GAP + 2} V${y - 3}` : `M${x - GAP + 2} ${cy} H${x - 3}`));
  }));
  let [right, bottom] = upright ? [full, GAP + columns.length * (height + GAP)] : [GAP + columns.length * (width + GAP) - GAP + 2, deepest * step];
  if (loop) {
    const last = columns.length - 1;
    if (upright) {
      const y = GAP + last * (height + GAP) + height / 2;
      parts.push(arrow(`M${GAP} ${y} H10 V${GAP + height / 2} H${GAP - 3}`));
    } else {
      const [from, to] = [GAP + last * (width + GAP) + width / 2, GAP + width / 2];
      parts.push(arrow(`M${from} ${height + 4} V${bottom + 12} H${to} V${height + 8}`));
      bottom += 20;
    }
  }
  const head = s("marker", { id: "arrow-head", viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 7, markerHeight: 7, orient: "auto" }, path("M0 0 L8 4 L0 8 Z", { class: "solid" }));
  return s("svg", {
    viewBox: `0 0 ${right} ${bottom}`, width: right, height: bottom, class: "composition", role: "img",
    "aria-label": `${t("axis.composition")}: ${columns.map((column) => column.map(({ role, name }) => `${t(`role.${role}`)} ${name}`).join(" + ")).join(" → ")}`,
  }, s("defs", {}, head), ...parts);
}

// The picture with its words beside it; `amber` says whether a block has constants of another machine.
export function composition(blocks, amber) {
  const place = h("div", { class: "drawing" });
  let shown = 0;
  new ResizeObserver(() => {
    const full = place.clientWidth;
    if (!full || Math.abs(full - shown) < 2) return;
    shown = full;
    place.replaceChildren(draw(blocks, amber, full));
  }).observe(place);
  return [place, h("ol", { class: "parts" }, blocks.map((block) => h("li", {},
    h("strong", {}, `${t(`role.${block.role}`)} ${block.name}`), `: ${block.doc}`, block.equation && [": ", h("code", {}, block.equation)],
    amber(block) && [" ", h("span", { class: "chip weak" }, t("axis.amber"))])))];
}

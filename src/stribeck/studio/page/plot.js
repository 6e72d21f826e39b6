// Plots: lines over time with one cursor and one range, curves, and a table behind each.
/* global uPlot */

import { h, number, t, table } from "./dom.js";

const sync = uPlot.sync("time");

export const colour = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

const axis = (label, more = {}) => ({
  label, stroke: colour("soft"), labelSize: 24, labelGap: 4, size: 56,
  grid: { stroke: colour("grid"), width: 1 }, ticks: { stroke: colour("grid"), width: 1 },
  font: "12px system-ui, sans-serif", labelFont: "13px system-ui, sans-serif", ...more,
});

// A plot in an element that keeps its width; the element is the figure.
export function figure(title, description, height, make, rows = null) {
  const place = h("div", { class: "canvas", role: "img", "aria-label": `${title}. ${description}` });
  const element = h("figure", {}, h("h3", {}, title), place);
  if (rows) element.append(h("details", {}, h("summary", {}, t("plot.table")), rows));
  // Drawn once it has a width, which it has when it is on the page; afterwards it keeps that.
  new ResizeObserver(() => {
    const width = place.clientWidth;
    if (!width) return;
    if (!element.plot) element.plot = make(place, width, height);
    else if (Math.abs(width - element.plot.width) > 1) element.plot.setSize({ width, height });
  }).observe(place);
  return element;
}

// Lines over time. `bands` are shaded spans drawn behind: {from, to, colour}.
export function timePlot(place, width, height, { data, series, label, bands = () => [], marks = () => [], onrange, zoom = true, legend = true }) {
  const options = {
    width, height,
    cursor: { sync: { key: sync.key }, drag: { x: true, y: false, setScale: false }, focus: { prox: 24 } },
    legend: { show: legend, live: true },
    scales: { x: { time: false } },
    axes: [axis(t("plot.time"), { size: 36 }), axis(label)],
    series: [{ label: t("plot.time"), value: (_, v) => (v === null ? "" : `${number(v, 6)} s`) },
      ...series.map((line) => ({
        label: line.label, stroke: colour(line.colour), width: line.width ?? 1.6, dash: line.dash,
        points: { show: line.points ?? false }, value: (_, v) => number(v, 5), spanGaps: false,
      }))],
    hooks: {
      drawClear: [(plot) => shade(plot, bands())],
      draw: [(plot) => mark(plot, marks())],
      setSelect: [(plot) => {
        if (plot.select.width < 4) return;
        const from = plot.posToVal(plot.select.left, "x");
        const to = plot.posToVal(plot.select.left + plot.select.width, "x");
        plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
        onrange?.(from, to);
      }],
    },
  };
  return new uPlot(options, data, place);
}

function shade(plot, bands) {
  const { ctx, bbox } = plot;
  ctx.save();
  for (const band of bands) {
    const from = Math.max(plot.valToPos(band.from, "x", true), bbox.left);
    const to = Math.min(plot.valToPos(band.to, "x", true), bbox.left + bbox.width);
    if (to <= from) continue;
    ctx.globalAlpha = band.alpha ?? 0.14;
    ctx.fillStyle = colour(band.colour);
    ctx.fillRect(from, bbox.top, Math.max(to - from, 1), bbox.height);
  }
  ctx.restore();
}

// Marks in view above which none are drawn: they would cover the line.
const DENSE = 500;

function mark(plot, all) {
  const { ctx, bbox } = plot;
  const { min, max } = plot.scales.x;
  const marks = all.filter(({ x, to }) => x <= max && (to ?? x) >= min);
  if (marks.length > DENSE) return;
  const ratio = window.devicePixelRatio || 1;
  ctx.save();
  ctx.beginPath();
  ctx.setLineDash([]);
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  for (const { x, y, to, colour: name, shape } of marks) {
    const left = plot.valToPos(x, "x", true);
    if (left > bbox.left + bbox.width) continue;
    const right = to === undefined ? left : plot.valToPos(to, "x", true);
    if (right < bbox.left) continue;
    const top = plot.valToPos(y, "y", true);
    ctx.strokeStyle = ctx.fillStyle = colour(name);
    ctx.lineWidth = 2.5 * ratio;
    ctx.beginPath();
    if (shape === "line") { ctx.moveTo(left, top); ctx.lineTo(right, top); ctx.stroke(); }
    else if (shape === "ring") { ctx.arc(left, top, 5 * ratio, 0, 7); ctx.lineWidth = 2 * ratio; ctx.stroke(); }
    else { ctx.arc(left, top, 3 * ratio, 0, 7); ctx.fill(); }
  }
  ctx.restore();
}

// Curves over one variable, with bands between pairs of lines, and points.
export function curvePlot(place, width, height, { data, series, xlabel, label, bands = [] }) {
  const options = {
    width, height,
    cursor: { drag: { x: true, y: true, uni: 20 } },
    scales: { x: { time: false } },
    legend: { show: true, live: false },
    hooks: { init: [(plot) => plot.root.querySelectorAll(".u-series").forEach((line, k) => { line.hidden = !series[k].label; })] },
    axes: [axis(xlabel, { size: 36 }), axis(label)],
    series: [{ label: xlabel }, ...series.map((line) => ({
      label: line.label, stroke: line.line === false ? undefined : colour(line.colour), width: line.width ?? 2, dash: line.dash, spanGaps: true,
      points: { show: line.points ?? false, size: line.size ?? 4, stroke: colour(line.colour), fill: colour(line.colour) },
      paths: line.line === false ? () => null : undefined,
    }))],
    bands: bands.map(({ high, low, colour: name }) => ({ series: [high, low], fill: fade(colour(name)) })),
  };
  return new uPlot(options, data, place);
}

const fade = (value) => `${value}33`;

// The rows behind a plot: at most a few dozen of the points drawn.
export function pointsTable(caption, heads, columns) {
  const length = columns[0].length;
  const step = Math.max(1, Math.ceil(length / 40));
  const rows = [];
  for (let k = 0; k < length; k += step) rows.push({ cells: columns.map((column) => number(column[k], 5)) });
  return table(caption, heads, rows);
}

// Several lines with abscissae of their own, on the union of these: what uPlot draws.
export function joined(lines) {
  return uPlot.join(lines.map(([x, y]) => [x, y]));
}

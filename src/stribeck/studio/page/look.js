// Step 2: the log over time, what the gate finds in it, and friction against velocity.

import { get, session } from "./api.js";
import { button, fill, h, menu, number, onward, row, t, table } from "./dom.js";
import { attempt, go } from "./main.js";
import { curvePlot, figure, pointsTable, timePlot } from "./plot.js";

const COLOURS = { position: "measured", command: "repeat3", velocity: "repeat1", force: "model", current: "repeat3", temperature: "repeat4" };
const PANELS = [["position", "command"], ["velocity"], ["force"], ["current"], ["temperature"]];

// A hairline is drawn ten times as fast as a broader one, and of many samples nothing else shows.
const breadth = (data) => (data.t.length > 600 ? 1 : 1.6);

// Lines of a log, asked for anew when the range changes; the last range wins: `show` answers whether
// its own was drawn.
export class Lines {
  constructor(log, overview) {
    this.log = log;
    this.overview = overview;
    this.range = overview.span;
    this.asked = 0;
    this.plots = [];
    this.data = null;
  }

  async show(from, to) {
    const [first, last] = this.overview.span;
    const width = Math.max(to - from, (last - first) * 1e-9);
    this.range = [Math.max(from, first), Math.min(from + width, last)];
    const asked = ++this.asked;
    const pixels = Math.round(Math.max(...this.plots.map(({ plot }) => plot.width), document.querySelector("main").clientWidth));
    const data = await get(`/logs/${this.log}/lines?since=${this.range[0]}&until=${this.range[1]}&pixels=${pixels}&mended=${Number(this.overview.mended)}`);
    if (asked !== this.asked) return false;
    this.data = data;
    // A frame for each: their lines together would keep the page from answering for too long.
    for (const { plot, names } of this.plots) {
      await new Promise(requestAnimationFrame);
      if (asked !== this.asked) return false;
      plot.batch(() => {
        for (const line of plot.series.slice(1)) line.width = breadth(data);
        plot.setData([data.t, ...names.map((name) => data.lines[name])], false);
        plot.setScale("x", { min: this.range[0], max: this.range[1] });
      });
    }
    return true;
  }

  move(share) {
    const [a, b] = this.range;
    const shift = (b - a) * share;
    return this.show(a + shift, b + shift);
  }

  zoom(factor) {
    const [a, b] = this.range;
    const middle = (a + b) / 2;
    const half = ((b - a) * factor) / 2;
    return this.show(middle - half, middle + half);
  }
}

// Buttons and keys that move the range of some lines.
export function rangeTools(lines, hint = "look.keys", done = () => {}) {
  const run = (work) => () => attempt(async () => { await work(); done(); });
  return h("div", { class: "pick", role: "toolbar", "aria-label": t("look.range"), onkeydown: (event) => {
    const keys = { ArrowLeft: () => lines.move(-0.25), ArrowRight: () => lines.move(0.25), "+": () => lines.zoom(0.5), "-": () => lines.zoom(2), 0: () => lines.show(...lines.overview.span) };
    if (keys[event.key]) { event.preventDefault(); run(keys[event.key])(); }
  } },
  button("look.left", run(() => lines.move(-0.25))), button("look.in", run(() => lines.zoom(0.5))),
  button("look.out", run(() => lines.zoom(2))), button("look.right", run(() => lines.move(0.25))),
  button("look.all", run(() => lines.show(...lines.overview.span))), h("span", { class: "note hint" }, t(hint)));
}

export function panels(lines, overview, more = {}) {
  const shown = PANELS.map((names) => names.filter((name) => name in overview.channels)).filter((names) => names.length);
  return shown.filter((names) => !more.only || names.includes(more.only)).map((names) => {
    const unit = overview.channels[names[0]];
    return figure(t(`channel.${names[0]}`), t("look.alt", { names: names.map((n) => t(`channel.${n}`)).join(", ") }),
      names.includes("position") ? 300 : 190, (place, width, height) => {
        const plot = timePlot(place, width, height, {
          data: [lines.data.t, ...names.map((name) => lines.data.lines[name])],
          series: names.map((name) => ({ label: t(`channel.${name}`), colour: COLOURS[name], width: breadth(lines.data), dash: name === "command" ? [5, 4] : undefined })),
          label: unit, bands: () => bands(overview, more.bands), marks: () => (names.includes("position") ? marks(overview) : []),
          onrange: more.onrange ?? ((from, to) => attempt(() => lines.show(from, to))),
        });
        plot.over.addEventListener("dblclick", () => attempt(() => lines.show(...overview.span)));
        plot.setScale("x", { min: lines.range[0], max: lines.range[1] });
        lines.plots.push({ plot, names });
        return plot;
      });
  });
}

// A log that is not judged yet: no findings, no marks.
export const unjudged = (outline) => ({ ...outline, findings: [], marks: { rests: [], slips: [], strokes: [], gaps: [] } });

// The same lines with findings and marks; `redraw` makes the plots anew where channels have come
// with these. The tools stay, and with them the focus and a range that was moved meanwhile.
export async function judge(lines, overview, redraw = null) {
  const same = Object.keys(overview.channels).join() === Object.keys(lines.overview.channels).join();
  Object.assign(lines.overview, overview);
  if (redraw && !same) lines.plots = [];
  while (!await lines.show(...lines.range));
  if (redraw && !same) redraw();
}

function bands(overview, more = () => []) {
  return [
    ...overview.marks.gaps.map(([from, to]) => ({ from, to, colour: "soft", alpha: 0.25 })),
    ...overview.findings.flatMap(({ places, harmful }) => places.map(([from, to]) => ({ from, to, colour: harmful ? "bad" : "warn", alpha: 0.25 }))),
    ...more(),
  ];
}

function marks(overview) {
  return [
    ...overview.marks.rests.map(([x, to, y]) => ({ x, to, y, shape: "line", colour: "ink" })),
    ...overview.marks.slips.map(([a, b, x, y]) => ({ x: (a + b) / 2, y: (x + y) / 2, shape: "dot", colour: "model" })),
  ];
}

export function lookStep() {
  const view = h("div");
  const chooser = h("div", { class: "pick" });
  const element = h("section", {}, h("h1", { tabindex: "-1" }, t("step.look")), h("p", { class: "lead" }, t("look.lead")), chooser, view);
  let selected = 0;
  let key = null;

  // The lines at once; what they mean, once the log has been judged.
  async function draw(state) {
    const now = JSON.stringify([state.choices.logs, state.choices.columns, state.choices.drive, state.choices.rig, state.choices.joint, state.choices.rate, selected]);
    if (now === key) return;
    key = now;
    fill(chooser, ...(state.logs.length > 1 ? [menu(state.logs.map((log, k) => [String(k), log.name]), String(selected),
      (value) => { selected = Number(value); draw(session.state); }, { "aria-label": t("logs.file") })] : []));
    const place = h("div");
    const judged = h("div", {}, h("p", { class: "note", role: "status" }, t("look.judging")));
    const found = h("span", { class: "note" });
    fill(view, h("p", { class: "note", role: "status" }, t("look.reading")));
    try {
      const outline = await get(`/logs/${selected}/outline`);
      if (key !== now) return;
      fill(view, place, judged, onward(button("next.axis", () => go("axis"), { class: "main", id: "next" }), found));
      const lines = outline.span && new Lines(selected, unjudged(outline));
      const plots = h("div");
      const drawPlots = () => fill(plots, ...panels(lines, lines.overview));
      if (lines) {
        await lines.show(...outline.span);
        fill(place, rangeTools(lines), plots);
        drawPlots();
      }
      const overview = await get(`/logs/${selected}/overview`);
      if (key !== now) return;
      if (lines) await judge(lines, overview, drawPlots);
      const { length } = overview.findings;
      fill(found, length ? t("look.some", { count: length }) : t("look.clean"));
      fill(judged, summary(overview), lines && findings(overview, lines), lines && await cloud(lines), quality(overview));
    } catch (error) {
      if (key === now) fill(view, h("p", { class: "state warn" }, error.message), h("p", {}, button("look.back", () => go("logs"), { class: "main" })));
    }
  }

  async function cloud(lines) {
    const points = await get(`/logs/${selected}/cloud?since=${lines.range[0]}&until=${lines.range[1]}`);
    if (!points) return null;
    const order = points.velocity.map((v, k) => [v, points.force[k]]).sort((a, b) => a[0] - b[0]);
    const data = [order.map(([v]) => v), order.map(([, f]) => f)];
    const [speed, force] = points.units;
    return figure(t("look.cloud"), t("look.cloud.alt"), 320, (place, width, height) => curvePlot(place, width, height, {
      data, xlabel: `${t("channel.velocity")} / ${speed}`, label: `${t("channel.force")} / ${force}`,
      series: [{ label: t("channel.force"), colour: "measured", line: false, points: true, size: 3 }],
    }), pointsTable(t("look.cloud"), [`${t("channel.velocity")} / ${speed}`, `${t("channel.force")} / ${force}`], data));
  }

  function findings(overview, lines) {
    if (!overview.findings.length) return h("p", { class: "state good" }, t("look.clean"));
    return h("div", { class: "state warn" }, h("h2", {}, t("look.findings")), h("ul", {}, overview.findings.map((finding) => h("li", {},
      `${t(`channel.${finding.channel}`)}: ${finding.sentence} `,
      finding.places.slice(0, 3).map(([from, to]) => h("button", { type: "button", onclick: () => attempt(async () => {
        const margin = Math.max(to - from, (overview.span[1] - overview.span[0]) / 200);
        await lines.show(from - margin, to + margin);
        document.querySelector(".canvas").scrollIntoView({ block: "center" });
      }) }, t("look.jump", { time: number(from, 5) })))))));
  }

  draw(session.state);
  return { element, update: draw };
}

function summary(overview) {
  const { marks } = overview;
  if (!marks.strokes) return null;
  const tiles = [["look.rows", overview.rows], ["look.strokes", marks.strokes.length], ["look.rests", marks.rests.length], ["look.slips", marks.slips.length], ["look.gaps", marks.gaps.length]];
  return h("dl", { class: "tiles" }, tiles.map(([key, value]) => h("div", {}, h("dt", {}, t(key)), h("dd", {}, number(value, 9)))));
}

function quality(overview) {
  return h("details", {}, h("summary", {}, t("look.numbers")),
    table(t("look.numbers"), [t("look.what"), t("value")], overview.lines.map(([what, value]) => row(what, value)), { class: "quality" }));
}

// Step 4: ranges dragged on the plot, law and method, and the search as it goes.

import { change, fitNumber, get, post, rigNamed, session } from "./api.js";
import { button, field, fill, h, menu, number, patch, row, t, table } from "./dom.js";
import { pointed, rigTitle } from "./logs.js";
import { Lines, judge, panels, rangeTools, unjudged } from "./look.js";
import { attempt, go } from "./main.js";
import { figure, timePlot } from "./plot.js";

// Names and values as they are typed, `a=1; b=2`, and as the choices have them.
const typed = (pairs) => Object.entries(pairs).map(([name, value]) => `${name}=${value}`).join("; ");
const pairs = (text) => Object.fromEntries(text.split(";").map((part) => part.split("=").map((word) => word.trim())).filter(([name, value]) => name && value));
const TIMES = /^([\d.]+)s:([\d.]+)s$/;

export const running = (state) => state.jobs.filter((job) => job.state === "waiting" || job.state === "running");

export function fitStep() {
  const plot = h("div");
  const ranges = h("div");
  const beyond = h("div", { role: "status" });
  const form = h("div");
  const jobs = h("div");
  const element = h("section", {}, h("h1", { tabindex: "-1" }, t("step.fit")), h("p", { class: "lead" }, t("fit.lead")), plot, ranges, beyond, form, jobs);
  let mode = "train";
  let key = null;
  let lines = null;
  let pending = 0;

  async function drawPlot(state) {
    const now = JSON.stringify([state.choices.logs, state.choices.columns, state.choices.drive, state.choices.rig]);
    if (now === key) return;
    key = now;
    fill(plot, h("p", { class: "note" }, t("look.reading")));
    try {
      const outline = await get("/logs/0/outline");
      if (!outline.span) { fill(plot, h("p", { class: "note" }, t("fit.table"))); return; }
      const overview = unjudged(outline);
      lines = new Lines(0, overview);
      await lines.show(...overview.span);
      if (key !== now) return;
      const modes = ["train", "holdout", "zoom"];
      fill(plot, h("fieldset", { class: "pick" }, h("legend", {}, t("fit.drag")), modes.map((name) => h("label", { class: "check" },
        h("input", { type: "radio", name: "mode", value: name, checked: name === mode, onchange: () => { mode = name; } }), t(`fit.${name}`)))),
      rangeTools(lines, "fit.keys"), ...panels(lines, overview, { only: "position", bands: () => chosenBands(), onrange: (from, to) => {
        if (mode === "zoom") attempt(() => lines.show(from, to));
        else attempt(() => change((choices) => ({ [mode]: [...choices[mode], `${round(from)}s:${round(to)}s`] })));
      } }));
      drawBeyond(session.state);
      const judged = await get("/logs/0/overview");
      if (key === now) await judge(lines, judged);
    } catch (error) {
      if (key === now) fill(plot, h("p", { class: "state warn" }, error.message));
    }
  }

  function round(time) {
    const span = lines.range[1] - lines.range[0];
    const digits = Math.max(0, Math.ceil(-Math.log10(span / 1000)));
    return Number(Math.max(time - lines.overview.span[0], 0).toFixed(digits));
  }

  const chosenBands = () => ["train", "holdout"].flatMap((name) => session.state.choices[name].flatMap((text) => {
    const match = TIMES.exec(text.replaceAll(" ", ""));
    const start = lines.overview.span[0];
    return match ? [{ from: start + Number(match[1]), to: start + Number(match[2]), colour: name === "train" ? "accent" : "good", alpha: 0.18 }] : [];
  }));

  function drawRanges(state) {
    lines?.plots.forEach((each) => each.plot.redraw());
    patch(ranges, h("div", { class: "fields" }, ["train", "holdout"].map((name) => field(`fit.${name}`, h("input", {
      type: "text", id: `fit-${name}`, value: state.choices[name].join("; "), placeholder: name === "train" ? t("fit.everything") : t("fit.nothing"),
      onchange: (event) => {
        const stretches = pointed(event.target.value).split(/[;,]/).map((part) => part.trim()).filter(Boolean);
        event.target.value = stretches.join("; ");
        attempt(() => change({ [name]: stretches }));
      },
    }), t(`fit.${name}.hint`)))));
  }

  // Ranges of time that begin when the log is over.
  function drawBeyond(state) {
    if (!lines) return;
    const [first, last] = lines.overview.span;
    const late = [...state.choices.train, ...state.choices.holdout].filter((text) => Number(TIMES.exec(text.replaceAll(" ", ""))?.[1] ?? 0) >= last - first);
    patch(beyond, ...late.map((range) => h("p", { class: "state warn" }, t("fit.beyond", { range, seconds: number(last - first, 4) }))));
  }

  function drawForm(state) {
    const { choices } = state;
    const rig = rigNamed(choices.rig);
    const laws = [...new Set([...(rig?.laws ?? []), ...Object.keys(session.catalogue.laws)])];
    const searched = rig?.approach !== "force_balance";
    const put = (name, numeric = false) => (event) => {
      const text = event.target.value.trim();
      attempt(() => change({ [name]: numeric ? (text ? Number(text) : null) : text }));
    };
    const law = choices.law || rig?.laws[0];
    patch(form, h("div", { class: "fields" },
      field("fit.law", menu([["", `${t("default")}: ${rig?.laws[0]}`], ...laws.map((name) => [name, name])], choices.law, (value) => attempt(() => change({ law: value })), { id: "fit-law" }), session.catalogue.laws[law]?.doc ?? ""),
      h("label", { class: "check" }, h("input", { type: "checkbox", checked: choices.directional, onchange: (event) => attempt(() => change({ directional: event.target.checked })) }), t("fit.directional"))),
    h("details", {}, h("summary", { id: "fit-more" }, t("fit.more")), h("div", { class: "fields" },
      searched && field("fit.method", menu([["", `${t("default")}: mbts`], ...Object.keys(session.catalogue.methods).map((name) => [name, name])], choices.method, (value) => attempt(() => change({ method: value })))),
      searched && field("fit.seed", h("input", { type: "number", min: "0", step: "1", value: choices.seed ?? "", placeholder: "0", onchange: put("seed", true) })),
      searched && field("fit.repeats", h("input", { type: "number", id: "fit-repeats", min: "1", step: "1", value: choices.repeats ?? "", placeholder: "3", onchange: put("repeats", true) })),
      searched && field("fit.budget", h("input", { type: "number", id: "fit-budget", min: "1", step: "1", value: choices.budget ?? "", placeholder: "8000", onchange: put("budget", true) })),
      searched && field("fit.loss", menu([["squares", "squares"], ["absolute", "absolute"]], choices.loss, (value) => attempt(() => change({ loss: value })), { id: "fit-loss" })),
      searched && field("fit.breakaway", menu(["auto", "common", "scattered"].map((name) => [name, t(`breakaway.${name}`)]), choices.breakaway, (value) => attempt(() => change({ breakaway: value })), { id: "fit-breakaway" })),
      !searched && field("fit.velocity", menu(["auto", "recorded", "position"].map((name) => [name, t(`velocity.${name}`)]), choices.velocity, (value) => attempt(() => change({ velocity: value })), { id: "fit-velocity" })),
      ["fixed", "bounds"].map((name) => field(`fit.${name}`, h("input", { type: "text", id: `fit-${name}`, value: typed(choices[name]), maxlength: "300", placeholder: name === "fixed" ? "offset=0" : "F_C=1:40",
        onchange: (event) => attempt(() => change({ [name]: pairs(event.target.value) })) }), t(`fit.${name}.hint`))),
      field("fit.delay", h("input", { type: "text", id: "fit-delay", value: choices.delay, maxlength: "40", onchange: put("delay") }), t("fit.delay.hint")))),
    h("p", {}, button("fit.run", () => attempt(async () => {
      await post("/jobs", { kind: "identify" });
      jobs.querySelector(".job")?.scrollIntoView({ block: "center" }); // what was asked for is below the fold
    }), { class: "main", id: "run" }), " ",
      h("span", { class: "note", role: "status", id: "duration" }, duration(state, rig))));
  }

  // How long a search may take: measured by a worker, for the choices as they are.
  function duration(state, rig) {
    if (!rig) return "";
    if (rig.approach === "force_balance") return t("fit.quick");
    const { estimate } = state;
    if (!estimate || estimate.state === "waiting" || estimate.state === "running") return t("fit.measuring");
    const { seconds, evaluations, evaluation } = estimate.progress;
    if (estimate.state === "failed" || seconds === undefined) return estimate.message || t("fit.slow");
    const span = seconds < 100 ? t("fit.seconds", { value: number(seconds, 2) }) : t("fit.minutes", { value: number(seconds / 60, 2) });
    return t("fit.estimate", { span, evaluations: evaluations.toLocaleString(document.documentElement.lang), cost: number(1e3 * evaluation, 2) });
  }

  // Asked for once the choices have been left alone for a moment.
  function askEstimate(state) {
    clearTimeout(pending);
    if (state.estimate || rigNamed(state.choices.rig)?.approach !== "output_error") return;
    pending = setTimeout(() => post("/jobs", { kind: "estimate" }).catch(() => {}), 800);
  }

  const views = new Map();

  function drawJobs(state) {
    const fits = state.jobs.filter((job) => job.kind === "identify").reverse();
    for (const job of fits) {
      if (!views.has(job.id)) views.set(job.id, jobView(job));
      views.get(job.id).update(job);
    }
    const elements = fits.map((job) => views.get(job.id).element);
    if (elements.some((each, k) => jobs.children[k + 1] !== each)) fill(jobs, h("h2", {}, t("fit.jobs")), ...elements);
  }

  function update(state) {
    drawPlot(state);
    drawRanges(state);
    drawBeyond(state);
    drawForm(state);
    drawJobs(state);
    askEstimate(state);
  }

  update(session.state);
  return { element, update, end: () => clearTimeout(pending) };
}

// A fit as it goes: its state in words, and the best motion so far over the measured one.
function jobView(first) {
  const line = h("p", { role: "status" });
  const tools = h("p");
  const picture = h("div");
  const element = h("article", { class: "job" }, h("h3", {}, `${t("fit.one", { number: fitNumber(first.id) })}: ${first.law} · ${rigTitle(first.rig)}`), line, tools, picture);
  let drawn = null;

  function update(job) {
    const { progress } = job;
    const repeats = progress.repeats ?? [];
    const best = Math.min(...repeats.map((r) => r.best ?? Infinity));
    const spent = repeats.reduce((sum, r) => sum + r.evaluations, 0);
    const words = job.state === "running" && progress.stage ? t(`stage.${progress.stage}`) : t(`state.${job.state}`);
    line.textContent = [words, spent ? t("fit.spent", { evaluations: spent.toLocaleString(document.documentElement.lang) }) : "",
      Number.isFinite(best) ? t("fit.best", { value: number(best), unit: progress.motion?.unit ?? "" }) : "",
      job.message].filter(Boolean).join("; ");
    line.className = job.state === "failed" ? "state warn" : job.state === "done" ? "state good" : "";
    const active = job.state === "waiting" || job.state === "running";
    const wanted = active ? (job.cancelled ? "ending" : "cancel") : job.state === "done" ? "open" : "";
    if (tools.dataset.tool !== wanted) {
      tools.dataset.tool = wanted;
      fill(tools, ...({
        cancel: () => [button("cancel", () => attempt(() => post(`/jobs/${job.id}/cancel`)))],
        ending: () => [t("fit.ending")],
        open: () => [button("next.verdict", () => go("verdict"), { class: "main" })],
      }[wanted]?.() ?? []));
    }
    if (active && progress.motion) motion(progress.motion, repeats);
    if (!active && job.state !== "done") fill(picture);
  }

  function motion(data, repeats) {
    if (!drawn) {
      drawn = figure(t("fit.motion"), t("fit.motion.alt"), 260, (place, width, height) => timePlot(place, width, height, {
        data: [data.t, data.measured, data.model], label: `${t("channel.position")} / ${data.unit}`,
        series: [{ label: t("measured"), colour: "measured", width: 2 }, { label: t("model"), colour: "model" }],
      }));
      fill(picture, drawn, h("div"));
    }
    drawn.plot?.setData([data.t, data.measured, data.model]);
    patch(picture.lastElementChild, table(t("fit.repeats"), [t("fit.repeat"), t("fit.evaluations"), t("fit.error", { unit: data.unit }), t("fit.ended")],
      repeats.map((r, k) => row(String(k + 1), r.evaluations, number(r.best), r.ended))));
  }

  return { element, update };
}

// Step 5: what is known of the axis; fits side by side; which law, and what to record next.

import { address, change, fitNumber, get, post, rigNamed, session } from "./api.js";
import { button, field, fill, h, number, onward, patch, printed, row, t, table, term } from "./dom.js";
import { rigTitle } from "./logs.js";
import { attempt, go } from "./main.js";
import { curvePlot, figure, joined, pointsTable, timePlot } from "./plot.js";

const PALETTE = ["model", "accent", "repeat2", "repeat3", "repeat4", "repeat5"];
const chips = { identified: "identified", weak: "weak", "not identifiable": "not", fixed: "fixed" };

// Options that a warning names, and the field of step 4 that is each.
const FIELDS = { train: "fit-train", holdout: "fit-holdout", set: "fit-fixed", bounds: "fit-bounds", velocity: "fit-velocity", delay: "fit-delay", law: "fit-law", budget: "fit-budget", repeats: "fit-repeats", breakaway: "fit-breakaway", loss: "fit-loss" };

const fits = (state) => state.jobs.filter((job) => job.kind === "identify" && job.state === "done");

export function verdictStep() {
  const chooser = h("div");
  const body = h("div");
  const further = h("div");
  const element = h("section", {}, h("h1", { tabindex: "-1" }, t("step.verdict")), chooser, body, further, onward(button("next.out", () => go("out"), { class: "main", id: "next" })));
  let key = null;
  let wanted = null; // ids of the fits that are shown; the last one until the person chooses
  let all = [];

  async function load(state) {
    const now = fits(state).map((job) => job.id).join();
    if (now !== key) {
      key = now;
      try { all = await get("/compare"); } catch (error) { fill(body, h("p", { class: "state warn" }, error.message)); return; }
      draw();
    }
    drawFurther(state);
  }

  const shown = () => {
    const ids = wanted ?? [all.at(-1)?.job];
    return all.filter((fit) => ids.includes(fit.job));
  };

  function draw() {
    patch(chooser, h("fieldset", { class: "pick" }, h("legend", {}, t("verdict.fits")), all.map((fit) => h("label", { class: "check" },
      h("input", { type: "checkbox", checked: shown().includes(fit), onchange: (event) => {
        const ids = shown().map(({ job }) => job);
        wanted = event.target.checked ? [...ids, fit.job] : ids.filter((id) => id !== fit.job);
        drawBody();
      } }), `${fitNumber(fit.job)}: ${fit.law} · ${rigTitle(fit.rig)} (${number(fit.objective.value, 3)} ${fit.objective.unit})`))));
    drawBody();
  }

  async function drawBody() {
    const chosen = shown();
    if (!chosen.length) { fill(body, h("p", {}, t("verdict.choose"))); return; }
    const several = chosen.length > 1;
    const parts = [...chosen.map((fit) => headline(fit, several)), tiles(chosen), parameters(chosen), ...chosen.map((fit) => told(fit, several)), curves(chosen)];
    fill(body, ...parts.filter(Boolean), await motions(chosen), links(chosen));
  }

  // What may be done with a fit, in a sentence.
  function headline(fit, several) {
    const all = Object.values(fit.parameters).filter((p) => p.verdict !== "fixed");
    const some = all.filter((p) => p.verdict === "identified").length;
    const key = some === all.length ? (fit.warnings.length ? "all_but" : "all") : some ? "some" : "none";
    return h("p", { class: `state ${some === all.length ? "good" : "warn"}`, id: several ? null : "headline" },
      several && h("strong", {}, `${t("fit.one", { number: fitNumber(fit.job) })}: `), t(`headline.${key}`, { some, all: all.length, warnings: fit.warnings.length }));
  }

  function tiles(chosen) {
    return h("div", {}, chosen.map((fit) => h("dl", { class: "tiles" },
      tile(`${t(fit.objective.unit === "%" ? "verdict.misfit.force" : "verdict.misfit")}${chosen.length > 1 ? `, ${fitNumber(fit.job)}` : ""}`, `${number(fit.objective.value, 3)} ${fit.objective.unit}`),
      fit.holdout.map((each) => tile(`${t("fit.holdout")} ${each.range}`, `${number(each.value, 3)} ${each.unit}`)),
      tile(t("verdict.known"), t("verdict.of", {
        some: Object.values(fit.parameters).filter((p) => p.verdict === "identified").length,
        all: Object.values(fit.parameters).filter((p) => p.verdict !== "fixed").length,
      })))));
  }

  const tile = (name, value) => h("div", {}, h("dt", {}, name), h("dd", {}, value));

  function parameters(chosen) {
    const names = [...new Set(chosen.flatMap((fit) => Object.keys(fit.parameters)))];
    const docs = Object.assign({}, ...chosen.flatMap((fit) => [session.catalogue.laws[fit.law]?.parameters, rigNamed(fit.rig)?.parameters]));
    const heads = [t("verdict.parameter"), t("meaning"), ...chosen.flatMap((fit) => {
      const of = chosen.length > 1 ? ` ${fitNumber(fit.job)}` : "";
      return [`${t("value")}${of}`, t("unit"), `95 %${of}`, `${t("verdict.verdict")}${of}`];
    })];
    return table(t("verdict.parameters"), heads, names.map((name) => row(name, term(`parameter.${name}`, docs[name]?.doc ?? ""), ...chosen.flatMap((fit) => {
      const p = fit.parameters[name];
      if (!p) return ["–", "", "", ""];
      const interval = p.low === null || p.low === undefined ? "–" : `${number(p.low)} … ${number(p.high)}`;
      const why = p.reason && p.verdict !== "identified" ? ` ${term(`because.${p.reason}`, p.reason)}` : "";
      return [number(p.value, 5), printed(p.unit), interval, h("span", {}, h("span", { class: `chip ${chips[p.verdict] ?? ""}` }, t(`known.${p.verdict}`)), why, p.borderline && ` (${t("verdict.borderline")})`)];
    }))));
  }

  function curves(chosen) {
    const { units } = chosen[0];
    const tables = [];
    const series = [];
    const bands = [];
    chosen.forEach((fit, k) => {
      const colour = PALETTE[k % PALETTE.length];
      const name = `${fitNumber(fit.job)}: ${fit.law}`;
      if (fit.friction.cloud_velocity.length) add(fit.friction.cloud_velocity, fit.friction.cloud_friction, { label: t("verdict.implied"), colour: "measured", line: false, points: true, size: 2 });
      fit.friction.curve.forEach((side, i) => {
        add(side.velocity, side.friction, { label: i ? "" : name, colour });
        if (side.low) {
          add(side.velocity, side.high, { label: "", colour, width: 0.6 });
          add(side.velocity, side.low, { label: i ? "" : t("verdict.band"), colour, width: 0.6 });
          bands.push({ high: series.length - 1, low: series.length, colour });
        }
      });
    });
    function add(x, y, line) {
      const order = x.map((v, i) => [v, y[i]]).filter(([v]) => v !== null).sort((a, b) => a[0] - b[0]);
      tables.push([order.map(([v]) => v), order.map(([, f]) => f)]);
      series.push(line);
    }
    if (!tables.length) return null;
    const data = joined(tables);
    const side = chosen[0].friction.curve.at(-1);
    return figure(t("verdict.curve"), t("verdict.curve.alt"), 360, (place, width, height) => curvePlot(place, width, height, {
      data, series, bands, xlabel: `${t("channel.velocity")} / ${units.velocity}`, label: `${t("verdict.friction")} / ${units.force}`,
    }), side && pointsTable(t("verdict.curve"), [`${t("channel.velocity")} / ${units.velocity}`, `${t("verdict.friction")} / ${units.force}`], [side.velocity, side.friction]));
  }

  function told(fit, several) {
    const of = several ? ` ${fitNumber(fit.job)}` : "";
    return h("div", {},
      fit.warnings.length > 0 && h("div", { class: "state warn" }, h("h2", {}, `${t("verdict.warnings")}${of}`), h("ul", {}, fit.warnings.map((w) => h("li", { lang: "en" }, w, ...ways(w))))),
      fit.notes.length > 0 && h("details", {}, h("summary", {}, `${t("verdict.notes")}${of}`), h("ul", {}, fit.notes.map((n) => h("li", { lang: "en" }, n)))));
  }

  // Where the page has what a warning spells as an option of the command line.
  function ways(warning) {
    const [, law] = /\b(?:use|try) law ([\w-]+)/.exec(warning) ?? [];
    if (law) return [h("button", { type: "button", class: "way", onclick: () => attempt(async () => { await change({ law, directional: false }); toField("fit-law"); }) }, `${t("verdict.take")}: ${law}`)];
    const named = [...new Set([...warning.matchAll(/--(\w+)/g)].map(([, option]) => option))].filter((option) => option in FIELDS);
    return named.map((option) => h("button", { type: "button", class: "way", onclick: () => toField(FIELDS[option]) }, `--${option} = ${t("step.fit")}: ${t(`fit.${FIELDS[option].slice(4)}`)}`));
  }

  function toField(id) {
    go("fit");
    const control = document.getElementById(id);
    const details = control?.closest("details");
    if (details) details.open = true;
    control?.focus();
  }

  async function motions(chosen) {
    const fit = chosen.at(-1);
    try {
      const result = await get(`/jobs/${fit.job}/result`);
      const motion = result.motions[0];
      if (!motion) return "";
      const unit = fit.objective.unit === "%" ? fit.units.force : fit.units.position;
      return h("div", {},
        figure(t("verdict.motion"), t("fit.motion.alt"), 260, (place, width, height) => timePlot(place, width, height, {
          data: [motion.t, motion.measured, motion.model], label: unit,
          series: [{ label: t("measured"), colour: "measured", width: 2 }, { label: t("model"), colour: "model" }],
        }), pointsTable(t("verdict.motion"), [t("plot.time"), t("measured"), t("model")], [motion.t, motion.measured, motion.model])),
        motion.residual.length > 0 && figure(t("verdict.residual"), t("verdict.residual.alt"), 170, (place, width, height) => timePlot(place, width, height, {
          data: [motion.residual_t, motion.residual], label: unit, legend: false, series: [{ label: t("verdict.residual"), colour: "repeat3" }],
        })));
    } catch (error) { return h("p", { class: "state warn" }, error.message); }
  }

  function links(chosen) {
    return h("ul", { class: "plain" }, chosen.flatMap((fit) => [
      h("li", {}, h("a", { href: address(`/jobs/${fit.job}/files/report.html`), target: "_blank", rel: "noopener" }, t("verdict.report", { number: fitNumber(fit.job) }))),
      h("li", {}, h("a", { href: address(`/jobs/${fit.job}/files/card.json?save=1`) }, t("verdict.card", { number: fitNumber(fit.job) }))),
    ]));
  }

  const views = new Map();

  function drawFurther(state) {
    const last = shown().at(-1);
    const work = state.jobs.filter((job) => job.kind === "select" || job.kind === "plan").reverse();
    const stamp = JSON.stringify([work.map((job) => [job.id, job.state, job.progress.task, job.message]), last?.job, state.choices.laws, state.choices.folds]);
    if (further.dataset.stamp === stamp) return;
    if (further.contains(document.activeElement) && document.activeElement.matches("input")) return;
    further.dataset.stamp = stamp;
    fill(further, h("h2", {}, t("verdict.further")), h("div", { class: "fields" },
      field("verdict.which", h("input", { type: "text", value: state.choices.laws.join(", "), maxlength: "300", placeholder: (rigNamed(state.choices.rig)?.laws ?? []).join(", "),
        onchange: (event) => attempt(() => change({ laws: event.target.value.split(",").map((law) => law.trim()).filter(Boolean) })) })),
      field("verdict.folds", h("input", { type: "number", min: "2", max: "100", step: "1", value: state.choices.folds ?? "",
        onchange: (event) => attempt(() => change({ folds: event.target.value ? Number(event.target.value) : null })) }), t("verdict.folds.hint"))),
    h("p", {},
      button("verdict.select", () => attempt(() => post("/jobs", { kind: "select" }))), " ",
      button("verdict.plan", () => attempt(() => post("/jobs", { kind: "plan", parent: shown().at(-1)?.job })))),
    ...work.map((job) => jobView(job)));
  }

  function jobView(job) {
    const line = [t(`kind.${job.kind}`), t(`state.${job.state}`)].join(": ");
    const said = job.state === "running" ? job.progress.task : job.message;
    const element = h("article", { class: "job" }, h("h3", {}, line), said && h("p", { class: job.state === "failed" ? "state warn" : "note", role: "status" }, said));
    if (job.state === "running" || job.state === "waiting") element.append(button("cancel", () => attempt(() => post(`/jobs/${job.id}/cancel`))));
    if (job.state !== "done") return element;
    if (!views.has(job.id)) {
      const place = h("div");
      views.set(job.id, place);
      get(`/jobs/${job.id}/result`).then((result) => fill(place, ...(job.kind === "select" ? selection(result) : plan(result))),
        (error) => fill(place, h("p", { class: "state warn" }, error.message)));
    }
    element.append(views.get(job.id));
    return element;
  }

  function selection(result) {
    const heads = [t("fit.law"), t("verdict.free"), `${t("verdict.misfit")} / ${result.unit}`, `${t("fit.holdout")} / ${result.unit}`];
    return [h("p", { class: "state good" }, t("verdict.law", { law: result.recommended })),
      h("ul", {}, [...result.ingredients.map(({ text }) => text), ...result.sentences].map((text) => h("li", {}, text))),
      table(t("verdict.laws"), heads, result.laws.map((c) => row(c.law, c.free, number(c.training_error), number(c.held_out_error)))),
      h("p", {}, button("verdict.take", () => attempt(async () => { await change({ law: result.recommended, directional: false }); go("fit"); })))];
  }

  function plan(result) {
    const names = Object.keys(result.experiments[0]?.parameters ?? {});
    return [
      table(t("verdict.experiments"), [t("verdict.experiment"), t("verdict.seconds"), ...names.map((name) => t("verdict.shrinks", { name }))],
        result.experiments.slice(0, 8).map((each) => row(each.words, number(each.seconds, 3), ...names.map((name) => number(each.parameters[name].factor, 2))))),
      h("ul", {}, result.notes.map((note) => h("li", {}, note)))];
  }

  load(session.state);
  return { element, update: load };
}

// Step 6: exports with what they lose, the compensation check, and the commands that do the same.

import { address, ask, change, fitNumber, get, post, session } from "./api.js";
import { button, field, fill, h, menu, number, patch, row, t, table } from "./dom.js";
import { rigTitle } from "./logs.js";
import { attempt, go, tell } from "./main.js";

const fits = (state) => state.jobs.filter((job) => job.kind === "identify" && job.state === "done");

export function outStep() {
  const form = h("div");
  const result = h("div");
  const check = h("div");
  const scripts = h("div");
  const element = h("section", {}, h("h1", { tabindex: "-1" }, t("step.out")), h("p", { class: "lead" }, t("out.lead")), form, result, check, scripts);
  const all = fits(session.state);
  let fit = all.at(-1).id;
  let options = { to: session.state.choices.target || "st" };
  let into = null;
  let asked = 0;

  const target = () => session.catalogue.targets.find(({ name }) => name === options.to);
  const query = (more = {}) => new URLSearchParams({ ...Object.fromEntries(Object.entries(options).filter(([, v]) => v)), ...more });

  function drawForm() {
    const put = (name) => (event) => { options = { ...options, [name]: event.target.value.trim() }; show(); };
    const chosen = target();
    patch(form, h("div", { class: "fields" },
      field("out.fit", menu(fits(session.state).map((job) => [String(job.id), `${fitNumber(job.id)}: ${job.law} · ${rigTitle(job.rig)}`]), String(fit), (value) => { fit = Number(value); show(); })),
      field("out.target", menu(session.catalogue.targets.map(({ name, doc }) => [name, `${name}: ${doc}`]), options.to, (value) => {
        options = { to: value };
        into = null;
        drawForm();
        attempt(() => change({ target: value }));
        show();
      }, { id: "target" }))),
    h("div", { class: "fields" },
      chosen.options.includes("name") && field("out.name", h("input", { type: "text", maxlength: "60", onchange: put("name") })),
      chosen.options.includes("settings") && field("out.settings", h("input", { type: "text", maxlength: "200", placeholder: "scale=0.9", onchange: put("set") }), t("out.settings.hint")),
      chosen.options.includes("points") && field("out.points", h("input", { type: "number", min: "2", placeholder: "20", onchange: put("points") })),
      chosen.options.includes("speed") && field("out.speed", h("input", { type: "number", step: "any", onchange: put("speed") })),
      chosen.options.includes("into") && field("out.into", h("input", { type: "file", onchange: (event) => attempt(async () => {
        const [file] = event.target.files;
        if (!file) return;
        into = await ask("POST", address(`/files?use=into&name=${encodeURIComponent(file.name)}`), file);
        options = { ...options, into: into.id };
        await show();
      }) }), t("out.into.hint")),
      chosen.options.includes("joint") && field("out.joint", h("input", { type: "text", maxlength: "100", onchange: put("joint") }))));
  }

  async function show() {
    const number_ = ++asked;
    try {
      const [answer, doubts] = await Promise.all([get(`/jobs/${fit}/export?${query()}`), caution(fit)]);
      if (number_ !== asked) return;
      fill(result, doubts,
        answer.notes.length > 0 && h("div", { class: "state warn" }, h("h2", {}, t("out.lost")), h("ul", {}, answer.notes.map((note) => h("li", {}, note)))),
        h("p", { class: "pick" }, h("a", { class: "download", href: address(`/jobs/${fit}/export?${query({ save: 1 })}`), download: answer.download }, t("out.download", { file: answer.download })),
          h("a", { href: address(`/jobs/${fit}/files/report.html`), target: "_blank", rel: "noopener" }, t("out.report"))),
        ...Object.entries(answer.files).map(([name, text]) => h("details", { open: text.length > 0 && Object.keys(answer.files).length === 1 },
          h("summary", {}, `${name} (${number(answer.sizes[name] / 1000, 3)} kB)`), text ? h("pre", { tabindex: "0" }, text) : h("p", {}, t("out.binary")))));
    } catch (error) {
      if (number_ === asked) fill(result, h("p", { class: "state warn" }, error.message));
    }
    drawScripts();
  }

  // Parameters that the data do not tell: code that compensates with them does what nobody has measured.
  async function caution(number) {
    const { law, parameters, warnings } = await get(`/jobs/${number}/result`);
    const own = session.catalogue.laws[law]?.parameters ?? parameters; // of the law alone is the code
    const doubtful = Object.entries(parameters).filter(([name, p]) => name in own && (p.verdict === "not identifiable" || p.verdict === "weak")).map(([name]) => name);
    if (!doubtful.length) return null;
    return h("div", { class: "state warn", id: "caution" }, h("p", {}, t("out.caution", { names: doubtful.join(", ") })),
      warnings.length > 0 && h("p", {}, button("out.why", () => go("verdict"))));
  }

  function drawCheck(state) {
    const jobs = state.jobs.filter((job) => job.kind === "compensate").reverse();
    const stamp = JSON.stringify(jobs.map((job) => [job.id, job.state, job.progress.task, job.message]));
    if (check.dataset.stamp === stamp) return;
    check.dataset.stamp = stamp;
    patch(check, h("h2", {}, t("out.compensation")), h("p", {}, t("out.compensation.lead")),
      h("p", {}, button("out.check", () => attempt(() => post("/jobs", { kind: "compensate", parent: fit })))),
      ...jobs.map((job) => h("article", { class: "job", "data-key": job.id },
        h("h3", {}, [t("fit.one", { number: fitNumber(job.parent) }), t(`state.${job.state}`), job.state === "running" ? job.progress.task ?? "" : "", job.message].filter(Boolean).join("; ")),
        (job.state === "running" || job.state === "waiting") && button("cancel", () => attempt(() => post(`/jobs/${job.id}/cancel`))),
        job.state === "done" && [h("img", { src: address(`/jobs/${job.id}/files/compensation.png`), alt: t("out.compensation.alt"), class: "wide" }),
          h("p", {}, h("a", { href: address(`/jobs/${job.id}/files/compensation.json?save=1`) }, t("out.compensation.file")))])));
  }

  async function drawScripts() {
    const answer = await get("/script");
    const exported = `stribeck export result/card.json --to ${options.to}${options.set ? ` --set ${options.set}` : ""} --out ${options.name || "friction"}`;
    const stopped = session.state.jobs.find((job) => job.id === fit)?.cancelled;
    fill(scripts, h("h2", {}, t("out.scripts")), h("p", {}, t(stopped ? "out.scripts.stopped" : "out.scripts.lead")),
      copy(t("out.command"), `${answer.command}\n${exported}`), ...Object.entries(answer.files).map(([name, text]) => copy(name, text)), copy("Python", answer.python));
  }

  const copy = (title, text) => h("div", { class: "copy" }, h("div", { class: "head" }, h("h3", {}, title),
    button("copy", () => attempt(async () => { await navigator.clipboard.writeText(text); tell(t("copied")); }), { "aria-label": `${t("copy")}: ${title}` })), h("pre", { tabindex: "0" }, text));

  drawForm();
  show();
  drawCheck(session.state);
  return { element, update: drawCheck };
}

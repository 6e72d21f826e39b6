// Step 3: the kind of axis or its parts, its constants and the drive.

import { OWN, address, ask, change, get, rigNamed, session, settle } from "./api.js";
import { composer } from "./composer.js";
import { composition } from "./composition.js";
import { button, fill, h, number, onward, patch, printed, t, table, term } from "./dom.js";
import { driveForm } from "./drive.js";
import { rigTitle } from "./logs.js";
import { attempt, go } from "./main.js";

// Origins of values that are of somebody else's machine, or nobody's.
const BORROWED = new Set(["the paper", "inferred", "example"]);
// What a session begins to compose: a mass under a measured force.
const FIRST = { rotary: false, controller: { none: {} }, motor: { force: {} }, transmission: { rigid: {} }, load: { mass: {} } };

export function axisStep() {
  const rigs = h("div");
  const own = h("div");
  const picture = h("div", { id: "composition" });
  const constants = h("div");
  const drive = h("div");
  const drawDrive = driveForm(drive);
  const drawOwn = composer(own);
  const next = onward();
  const element = h("section", {}, h("h1", { tabindex: "-1" }, t("step.axis")), h("p", { class: "lead" }, t("axis.lead")), rigs, picture, own, constants, drive, next);
  let suggestion = null;
  let known = {}; // constants that the log states itself
  let key = null;
  let order = null; // the rigs, what the log suggests first: cards do not move under a pointer

  async function suggest(state) {
    const now = JSON.stringify([state.choices.logs, state.choices.columns, state.choices.rig]);
    if (now === key) return;
    key = now;
    let stated = {};
    try {
      const overview = await get("/logs/0/overview");
      suggestion = { rig: overview.rig, reason: overview.rig_reason };
      stated = overview.stated;
    } catch (error) { suggestion = { rig: "", reason: error.message }; }
    arrange();
    if (key !== now) return;
    known = stated;
    drawRigs(session.state);
    drawPicture(session.state, rigNamed(session.state.choices.rig));
    drawConstants(session.state, rigNamed(session.state.choices.rig));
  }

  const choose = (name) => attempt(() => change(({ axis }) => ({
    rig: name, constants: {}, fixed: {}, bounds: {}, law: "", velocity: "auto", breakaway: "auto", axis: name === OWN && !Object.keys(axis).length ? FIRST : axis,
  })));

  const option = (state, name, title, doc, chip) => h("label", { class: "choice" },
    h("input", { type: "radio", name: "rig", value: name, checked: state.choices.rig === name, onchange: () => choose(name) }),
    h("span", {}, h("strong", {}, title), chip && " ", chip && h("span", { class: "chip identified" }, chip), h("br"), doc));

  function suggested() {
    if (!suggestion) return t("look.reading");
    const { rig, reason } = suggestion;
    return rig ? t("axis.suggested", { rig: rigTitle(rig), reason: term(`reason.${reason}`, reason) }) : t("axis.none", { reason });
  }

  function arrange() {
    if (order) return;
    const all = Object.keys(session.catalogue.rigs);
    order = all.sort((a, b) => (b === suggestion?.rig) - (a === suggestion?.rig));
    drawRigs(session.state);
  }

  function drawRigs(state) {
    if (!order) return;
    patch(rigs, h("fieldset", { class: "cards" }, h("legend", {}, t("axis.rig")),
      h("p", { class: "note", role: "status" }, suggested()),
      h("div", { class: "grid" }, order.map((name) => option(state, name, rigTitle(name), term(`rig.${name}.doc`, rigNamed(name).doc), name === suggestion?.rig && t("axis.fits"))),
        option(state, OWN, state.choices.axis.name || t("axis.own"), t("axis.own.doc")))),
    h("div", { class: "field" }, h("label", { for: "rig-file" }, t("axis.file")),
      h("input", { type: "file", id: "rig-file", accept: ".toml", onchange: (event) => attempt(async () => {
        const [file] = event.target.files;
        if (file) settle(await ask("POST", address(`/rig?name=${encodeURIComponent(file.name)}`), file));
      }) }), h("p", { class: "note" }, t("axis.file.hint"))));
  }

  function isAmber(state, name, constant) {
    return !state.choices.constants[name] && !(name in known) && !state.choices.exact && BORROWED.has(constant.origin);
  }

  // What a description lacks to be an axis.
  function lacking(state) {
    const fit = state.steps.find(({ name }) => name === "fit");
    return state.choices.rig && fit.lock === "lock.axis" ? fit.detail : "";
  }

  function drawPicture(state, rig) {
    const stamp = JSON.stringify([rig?.composition, lacking(state), known, state.choices.constants, state.choices.exact, document.documentElement.lang]);
    if (picture.dataset.stamp === stamp) return;
    picture.dataset.stamp = stamp;
    const amber = (block) => block.constants.some((name) => rig.constants[name] && isAmber(state, name, rig.constants[name]));
    fill(picture, lacking(state) && h("p", { class: "state warn", role: "status" }, lacking(state)), rig && [h("h2", {}, t("axis.composition")), composition(rig.composition, amber),
      rig.equation && h("details", {}, h("summary", {}, t("axis.equation")), h("ul", {}, rig.equation.map((line) => h("li", {}, h("code", {}, line))))),
      h("p", { class: "note" }, rig.approach === "force_balance" ? t("axis.balance") : t("axis.simulated"))]);
  }

  function drawConstants(state, rig) {
    if (!rig || !Object.keys(rig.constants).length) { fill(constants); return; }
    // Those of an axis of parts stand with the parts.
    const parts = state.choices.rig === OWN && !state.choices.axis.kind ? rig.composition.flatMap((block) => block.constants) : [];
    const rows = Object.entries(rig.constants).filter(([name]) => !parts.includes(name)).map(([name, constant]) => {
      const stated = state.choices.constants[name];
      const amber = isAmber(state, name, constant);
      return { "data-key": name, class: amber ? "untouched" : null, cells: [
        name,
        name in known ? number(known[name], 6) : h("input", { type: "text", class: "short", value: stated ?? "", placeholder: number(constant.value, 6), maxlength: "60", "aria-label": `${name}: ${constant.doc}`,
          onchange: (event) => {
            const value = event.target.value.trim();
            attempt(() => change(({ constants: { [name]: _, ...rest } }) => ({ constants: value ? { ...rest, [name]: value } : rest })));
          } }),
        stated || name in known || !constant.tolerance || state.choices.exact ? "" : `±${number(constant.tolerance, 3)}`,
        printed(constant.unit || "1"), constant.doc,
        name in known ? t("origin.log") : stated ? t("origin.yours") : `${t(`origin.${constant.origin}`)}${amber ? ` – ${t("axis.amber")}` : ""}`, stated || name in known ? "" : constant.source,
      ] };
    });
    patch(constants, h("h2", {}, t("axis.constants")), h("p", { class: "note" }, t("axis.constants.hint")),
      table(t("axis.constants"), [t("axis.constant"), t("value"), t("tolerance"), t("unit"), t("meaning"), t("origin"), t("source")], rows),
      h("label", { class: "check" }, h("input", { type: "checkbox", checked: state.choices.exact, onchange: (event) => attempt(() => change({ exact: event.target.checked })) }), t("axis.exact")));
  }

  function drawNext(state) {
    const { lock } = state.steps.find(({ name }) => name === "fit");
    patch(next, button("next.fit", () => go("fit"), { class: "main", id: "next", disabled: Boolean(lock) }), " ",
      lock && h("span", { class: "note" }, [t(lock), lacking(state)].filter(Boolean).join(": ")));
  }

  function update(state) {
    const rig = rigNamed(state.choices.rig);
    suggest(state);
    drawRigs(state);
    drawOwn(state);
    drawPicture(state, rig);
    drawConstants(state, rig);
    drawDrive(state);
    drawNext(state);
  }

  update(session.state);
  const patience = setTimeout(arrange, 300); // ms for a log that takes long to judge
  return { element, update, end: () => clearTimeout(patience) };
}

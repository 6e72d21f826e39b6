// Step 3: the rig, its constants and the drive.

import { change, get, session } from "./api.js";
import { button, field, fill, h, menu, number, row, t, table } from "./dom.js";
import { attempt, go } from "./main.js";

// Origins of values that are of somebody else's machine, or nobody's.
const BORROWED = new Set(["the paper", "inferred", "example"]);

export function axisStep() {
  const rigs = h("div");
  const picture = h("div");
  const constants = h("div");
  const drive = h("div");
  const element = h("section", {}, h("h1", { tabindex: "-1" }, t("step.axis")), h("p", { class: "lead" }, t("axis.lead")), rigs, picture, constants, drive,
    h("p", {}, button("next.fit", () => go("fit"), { class: "main", id: "next" })));
  let suggestion = null;
  let key = null;

  async function suggest(state) {
    const now = JSON.stringify([state.choices.logs, state.choices.columns]);
    if (now === key) return;
    key = now;
    try {
      const overview = await get("/logs/0/overview");
      suggestion = { rig: overview.rig, reason: overview.rig_reason };
    } catch (error) { suggestion = { rig: "", reason: error.message }; }
    if (key === now) drawRigs(session.state);
  }

  function drawRigs(state) {
    const all = Object.entries(session.catalogue.rigs);
    all.sort(([a], [b]) => (b === suggestion?.rig) - (a === suggestion?.rig));
    const focused = rigs.contains(document.activeElement) ? document.activeElement.value : null;
    fill(rigs, h("fieldset", { class: "cards" }, h("legend", {}, t("axis.rig")),
      suggestion && h("p", { class: "note" }, suggestion.rig ? t("axis.suggested", { rig: suggestion.rig, reason: suggestion.reason }) : t("axis.none", { reason: suggestion.reason })),
      h("div", { class: "grid" }, all.map(([name, rig]) => h("label", { class: "choice" },
        h("input", { type: "radio", name: "rig", value: name, checked: state.choices.rig === name,
          onchange: () => attempt(() => change({ rig: name, constants: {}, fixed: {}, bounds: {}, law: "" })) }),
        h("span", {}, h("strong", {}, name), name === suggestion?.rig && h("span", { class: "chip identified" }, t("axis.fits")), h("br"), rig.doc))))));
    if (focused) rigs.querySelector(`input[value="${focused}"]`)?.focus();
  }

  function drawPicture(state) {
    const rig = session.catalogue.rigs[state.choices.rig];
    fill(picture, ...(rig ? [h("h2", {}, t("axis.composition")),
      h("ol", { class: "chain" }, (rig.equation ?? [rig.doc]).map((part) => h("li", {}, part))),
      h("p", { class: "note" }, rig.approach === "force_balance" ? t("axis.balance") : t("axis.simulated"))] : []));
  }

  function drawConstants(state) {
    const rig = session.catalogue.rigs[state.choices.rig];
    if (!rig || !Object.keys(rig.constants).length) { fill(constants); return; }
    const rows = Object.entries(rig.constants).map(([name, constant]) => {
      const stated = state.choices.constants[name];
      const borrowed = !stated && !state.choices.exact && BORROWED.has(constant.origin);
      const usual = `${number(constant.value, 6)}${constant.tolerance ? `±${number(constant.tolerance, 3)}` : ""}`;
      return { class: borrowed ? "untouched" : null, cells: [
        name,
        h("input", { type: "text", class: "short", value: stated ?? "", placeholder: usual, maxlength: "60", "aria-label": `${name}: ${constant.doc}`,
          onchange: (event) => {
            const value = event.target.value.trim();
            attempt(() => change(({ constants: { [name]: _, ...rest } }) => ({ constants: value ? { ...rest, [name]: value } : rest })));
          } }),
        constant.unit || "1", constant.doc,
        stated ? t("origin.yours") : `${t(`origin.${constant.origin}`)}${borrowed ? ` – ${t("axis.amber")}` : ""}`, stated ? "" : constant.source,
      ] };
    });
    const focused = constants.contains(document.activeElement) ? document.activeElement.getAttribute("aria-label") : null;
    fill(constants, h("h2", {}, t("axis.constants")), h("p", { class: "note" }, t("axis.constants.hint")),
      table(t("axis.constants"), [t("axis.constant"), t("value"), t("unit"), t("meaning"), t("origin"), t("source")], rows),
      h("label", { class: "check" }, h("input", { type: "checkbox", checked: state.choices.exact, onchange: (event) => attempt(() => change({ exact: event.target.checked })) }), t("axis.exact")));
    if (focused) [...constants.querySelectorAll("input")].find((each) => each.getAttribute("aria-label") === focused)?.focus();
  }

  function drawDrive(state) {
    const chain = state.choices.drive;
    const conventions = session.catalogue.drives;
    const convention = conventions.find(({ name }) => name === chain.convention);
    const put = (name, value) => {
      const changed = ({ drive: { [name]: _, ...rest } }) => ({ drive: value ? { ...rest, [name]: value } : rest });
      return attempt(() => change(changed));
    };
    const numbers = new Set([...(convention?.needs ?? []), ...Object.keys(chain).filter((n) => !["convention", "signal", "side", "motion", "reversed"].includes(n))]);
    fill(drive, h("details", { open: Object.keys(chain).length > 0 || null }, h("summary", {}, t("axis.drive")),
      h("p", { class: "note" }, t("axis.drive.hint")),
      h("div", { class: "fields" },
        field("axis.convention", menu([["", t("axis.no_convention")], ...conventions.map(({ name, drives }) => [name, `${drives} (${name})`])], chain.convention ?? "",
          (value) => attempt(() => change({ drive: value ? { convention: value } : {} }))), convention?.meaning ?? ""),
        field("axis.signal", h("input", { type: "text", value: chain.signal ?? "", placeholder: "A rms", maxlength: "60", onchange: (event) => put("signal", event.target.value.trim()) }), t("axis.signal.hint")),
        [...numbers].map((name) => field(name, h("input", { type: "text", value: chain[name] ?? "", maxlength: "100", onchange: (event) => put(name, event.target.value.trim()) }))),
        ["kt", "gear", "lead", "efficiency"].filter((name) => !numbers.has(name)).map((name) => field(name, h("input", { type: "text", value: "", maxlength: "100", onchange: (event) => put(name, event.target.value.trim()) }), t(`axis.${name}.hint`))))));
  }

  function update(state) {
    suggest(state);
    drawRigs(state);
    drawPicture(state);
    drawConstants(state);
    drawDrive(state);
    element.querySelector("#next").disabled = Boolean(state.steps.find(({ name }) => name === "fit").lock);
  }

  update(session.state);
  return { element, update };
}

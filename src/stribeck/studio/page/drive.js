// What a drive recorded, and how it becomes the force of the axis: asked number by number.

import { change, session } from "./api.js";
import { field, h, menu, patch, t, term } from "./dom.js";
import { attempt } from "./main.js";

const WORDS = new Set(["convention", "signal", "side", "motion", "reversed"]);
const SIGNALS = ["% of rated torque", "‰ of rated torque", "% of rated current", "‰ of rated current", "% of peak torque", "A rms", "A peak", "A", "mA", "counts", "V", "N m", "N"];

// The numbers without which a signal is no force.
function needed(chain, convention) {
  if (convention) return convention.needs;
  const signal = chain.signal ?? "";
  const base = /of (rated|standstill|peak) (torque|force|current)/.exec(signal);
  const names = base ? [`${base[1]}_${base[2]}`] : /^(counts|inc|m?V)\b/.test(signal) ? ["scale"] : [];
  return /current|^m?A\b/.test(signal) ? [...names, "kt"] : names;
}

export function driveForm(place) {
  const put = (name, value) => attempt(() => change(({ drive: { [name]: _, ...rest } }) => ({ drive: value ? { ...rest, [name]: value } : rest })));

  const number = (name, chain, examples, wanted = false) => field(`drive.${name}`, h("input", {
    type: "text", id: `drive-${name}`, "aria-required": wanted ? "true" : null, value: chain[name] ?? "", placeholder: examples[name] ?? session.catalogue.numbers[name].example, maxlength: "100",
    onchange: (event) => put(name, event.target.value.trim()),
  }), [wanted && t("drive.needed"), term(`drive.${name.replace(/^(rated|standstill|peak)_.*/, "base")}.doc`, session.catalogue.numbers[name].doc)].filter(Boolean).join(" "));

  // What a chain lacks, in the words of the form instead of those of a file.
  function refusal(error) {
    const [, missing] = /, and (\w+) is missing: write/.exec(error) ?? [];
    if (missing) return t("drive.missing", { number: t(`drive.${missing}`) });
    return error.replace(/^drive\.(\w+): /, (_, name) => `${t(`drive.${name}`)}: `);
  }

  function chainText(chain, convention) {
    const names = Object.keys(session.catalogue.numbers).filter((name) => chain[name] && session.catalogue.numbers[name].acting);
    const parts = [(chain.signal && term(`signal.${chain.signal}`, chain.signal)) || convention?.meaning, ...names.map((name) => `${t(`drive.${name}`)} ${chain[name]}`), t("channel.force")];
    return h("ol", { class: "chain" }, parts.filter(Boolean).map((part) => h("li", {}, part)));
  }

  return function draw(state, open = Boolean(state.drive.error)) {
    const chain = state.choices.drive;
    const convention = session.catalogue.drives.find(({ name }) => name === chain.convention);
    const first = needed(chain, convention);
    const known = Object.keys(session.catalogue.numbers);
    const usual = ["kt", "gear", "lead", "counts_per_turn"].filter((name) => !first.includes(name));
    const rest = known.filter((name) => !first.includes(name) && !usual.includes(name) && (chain[name] || ["efficiency", "efficiency_backward", "rotor_inertia", "mass"].includes(name)));
    const examples = convention?.examples ?? {};
    const begun = Object.keys(chain).length > 0;
    patch(place, h("details", { open, class: "drive" }, h("summary", {}, t("axis.drive")),
      h("p", { class: "note" }, t("axis.drive.hint")),
      h("div", { class: "fields" },
        field("axis.convention", menu([["", t("axis.no_convention")], ...session.catalogue.drives.map(({ name, drives, object }) => [name, `${drives}: ${object}`])], chain.convention ?? "",
          (value) => attempt(() => change({ drive: value ? { convention: value } : {} })), { id: "drive-convention" }), convention ? [convention.meaning, convention.note].filter(Boolean).join("; ") : ""),
        !convention && field("axis.signal", menu([["", "–"], ...[...new Set([...SIGNALS, chain.signal ?? SIGNALS[0]])].map((signal) => [signal, term(`signal.${signal}`, signal)])], chain.signal ?? "",
          (value) => put("signal", value), { id: "drive-signal" }), t("axis.signal.hint")),
        (begun ? [...first, ...usual] : []).map((name) => number(name, chain, examples, first.includes(name)))),
      begun && h("details", {}, h("summary", {}, t("axis.drive.more")), h("div", { class: "fields" },
        rest.map((name) => number(name, chain, examples)),
        field("drive.side", menu([["", t("drive.axis")], ["motor", t("drive.motor")]], chain.side ?? "", (value) => put("side", value), { id: "drive-side" }), t("drive.side.hint")),
        field("drive.motion", menu([["", t("drive.axis")], ["motor", t("drive.motor")]], chain.motion ?? "", (value) => put("motion", value), { id: "drive-motion" }), t("drive.motion.hint")),
        h("label", { class: "check" }, h("input", { type: "checkbox", id: "drive-reversed", checked: chain.reversed === true, onchange: (event) => put("reversed", event.target.checked) }), t("drive.reversed")))),
      begun && chainText(chain, convention),
      begun && h("p", { class: state.drive.error ? "state warn" : "note", role: "status" }, state.drive.error ? refusal(state.drive.error) : state.drive.sentence)));
  };
}

export const stated = (state) => Object.keys(state.choices.drive).some((name) => !WORDS.has(name) || name === "signal" || name === "convention");

// Step 1: logs, and which column is which channel.

import { address, ask, change, get, post, session, settle } from "./api.js";
import { button, field, fill, h, menu, number, row, t, table } from "./dom.js";
import { driveForm } from "./drive.js";
import { attempt, go, tell } from "./main.js";

const CHANNELS = ["position", "command", "velocity", "acceleration", "force", "current", "voltage", "temperature", "pressure", "back_pressure", "time"];
// Units that drives write, by channel: to choose from, where a head says none.
const UNITS = {
  position: ["mm", "m", "um", "deg", "rad", "inc"], command: ["mm", "m", "um", "deg", "rad", "inc"], velocity: ["mm/s", "m/s", "r/min", "deg/s", "rad/s"],
  acceleration: ["m/s^2", "mm/s^2", "rad/s^2"], force: ["N", "N m", "%", "A", "V"], current: ["A", "mA"], voltage: ["V"], temperature: ["degC", "K"],
  pressure: ["bar", "Pa"], back_pressure: ["bar", "Pa"], time: ["s", "ms", "us"],
};
// What a refusal proposes to type, which the table does here, or a button.
const ADVICE = /: (?:say|map it|write a \[drive\]) .*/;
const PROPOSED = /(\w+) ?= ?"([^"]+)"/;
const WORDS = ["joint", "rate", "time_unit", "stamp", "episode", "subtract"];

export async function upload(files) {
  for (const file of files) {
    settle(await ask("POST", address(`/files?name=${encodeURIComponent(file.name)}`), file));
  }
}

// All files of what was dropped, those of folders too.
async function dropped(items) {
  const files = [];
  const walk = async (entry) => {
    if (entry.isFile) files.push(await new Promise((done, fail) => entry.file(done, fail)));
    else {
      const reader = entry.createReader();
      for (;;) {
        const entries = await new Promise((done, fail) => reader.readEntries(done, fail));
        if (!entries.length) break;
        for (const each of entries) await walk(each);
      }
    }
  };
  const entries = [...items].map((item) => item.webkitGetAsEntry()).filter(Boolean);
  for (const entry of entries) await walk(entry);
  return files;
}

export function logsStep() {
  const list = h("div");
  const channels = h("div", { id: "channels" });
  const input = h("input", { type: "file", multiple: true, id: "files", onchange: (event) => attempt(() => upload(event.target.files)) });
  const zone = h("div", {
    class: "drop",
    ondragover: (event) => { event.preventDefault(); zone.classList.add("over"); },
    ondragleave: () => zone.classList.remove("over"),
    ondrop: (event) => {
      event.preventDefault();
      zone.classList.remove("over");
      attempt(async () => upload(await dropped(event.dataTransfer.items)));
    },
  }, h("label", { for: "files" }, t("logs.drop")), input, h("p", { class: "note" }, t("logs.formats")));
  const drive = h("div");
  const drawDrive = driveForm(drive);
  const next = h("p");
  const element = h("section", {}, h("h1", { tabindex: "-1" }, t("step.logs")), h("p", { class: "lead" }, t("logs.lead")), zone, list, channels, drive, next);
  let selected = 0;
  let key = null;

  async function showChannels(state) {
    const now = JSON.stringify([state.logs[selected]?.id, state.choices.columns, WORDS.map((w) => state.choices[w]), state.choices.rig, state.choices.drive]);
    if (now === key) return;
    key = now;
    if (!state.logs.length) { fill(channels); fill(drive); return; }
    let contents = null;
    try { contents = await get(`/logs/${selected}/contents`); } catch (error) {
      if (key !== now) return;
      fill(channels, h("p", { class: "state warn" }, error.message), words(session.state));
      drawDrive(session.state);
      return;
    }
    if (key !== now) return;
    const focused = channels.contains(document.activeElement) ? document.activeElement.getAttribute("aria-label") : null;
    fill(channels, ...contentsView(contents, session.state));
    if (focused) [...channels.querySelectorAll("[aria-label]")].find((each) => each.getAttribute("aria-label") === focused)?.focus();
    // Where a column is a share, a current or counts, the drive is what is missing to read it.
    if (contents.lacking.includes("[drive]") || Object.keys(session.state.choices.drive).length) drawDrive(session.state, true);
    else fill(drive);
  }

  // The next log with the same heads is read as this one.
  const keep = () => attempt(async () => {
    await post(`/logs/${selected}/map`);
    key = null;
    await showChannels(session.state);
    tell(t("logs.kept"));
  });

  // Channel and unit of a column, as chosen; both are empty where nothing was.
  function chosenFor(channel, state) {
    const found = Object.entries(state.choices.columns).find(([, c]) => c === channel.name || c.startsWith(`${channel.name} [`));
    return found ? { name: found[0], unit: found[1].slice(channel.name.length).replace(/^ \[|\]$/g, "") } : { name: "", unit: "" };
  }

  // The columns that nobody has chosen, as their names say: each channel once.
  function guessed(contents, state) {
    const columns = { ...state.choices.columns };
    for (const channel of contents.channels) if (channel.taken) columns[channel.taken] ??= channel.name;
    const free = contents.channels.filter((channel) => !channel.taken && !chosenFor(channel, state).name);
    for (const channel of free) {
      const name = channel.guesses.find((guess) => !(guess in columns));
      if (name) columns[name] = channel.name;
    }
    return Object.keys(columns).length > Object.keys(state.choices.columns).length ? columns : null;
  }

  function lacking(contents, state) {
    const [advice = ""] = ADVICE.exec(contents.lacking) ?? [];
    const [, name, column] = PROPOSED.exec(advice) ?? [];
    const proposed = !advice.includes("[drive]") && contents.channels.some((channel) => column?.startsWith(channel.name));
    const columns = /\bcolumn\b/.test(contents.lacking) && !advice.includes("[drive]") ? guessed(contents, state) : null;
    const named = (all) => Object.entries(all).map(([each, head]) => `${t(`channel.${each}`)} ← ${head}`).join(", ");
    return h("div", { class: "state warn", id: "lacking" }, h("p", {}, advice ? `${contents.lacking.replace(advice, "")}.` : contents.lacking),
      contents.rig && h("p", {}, button("logs.as_rig", () => attempt(() => change({ rig: contents.rig })), { class: "main", id: "as-rig" }), ` ${t("logs.heads", { rig: contents.rig })}`),
      columns && h("p", {}, button("logs.guess", () => attempt(() => change({ columns })), { class: "main", id: "guess" }), ` ${named(columns)}`),
      !columns && proposed && h("p", {}, h("button", { type: "button", class: "main", id: "proposed", onclick: () => attempt(() => change(({ columns: now }) => ({ columns: { ...now, [name]: column } }))) },
        t("logs.proposed", { column, channel: t(`channel.${name}`) })), ` ${t("logs.or_unit")}`),
      !columns && advice && !proposed && h("p", {}, t(advice.includes("[drive]") ? "logs.drive" : "logs.choose")));
  }

  function contentsView(contents, state) {
    const rows = contents.channels.map((channel) => row(
      channel.name,
      unitControl(channel, state),
      number(channel.count, 9), channel.rate ? `${number(channel.rate)} Hz` : "–",
      menu([["", t("logs.not")], ...CHANNELS.map((c) => [c, t(`channel.${c}`)])], chosenFor(channel, state).name || channel.taken,
        (value) => attempt(() => take(channel, value, chosenFor(channel, state).unit)), { "aria-label": `${channel.name}: ${t("logs.taken")}` }),
      reason(channel, state)));
    return [
      h("h2", {}, contents.file), h("p", {}, t("logs.format", { format: contents.format })),
      contents.lacking && lacking(contents, state),
      contents.problems.length > 0 && h("ul", {}, contents.problems.map((p) => h("li", {}, p))),
      contents.kept && h("p", { class: "note" }, t("logs.as_kept")),
      table(t("logs.channels"), [t("logs.column"), t("unit"), t("logs.count"), t("logs.rate"), t("logs.taken"), t("logs.why")], rows),
      Object.entries(UNITS).map(([name, units]) => h("datalist", { id: `units-${name}` }, units.map((unit) => h("option", { value: unit })))),
      contents.mapped && !contents.kept && h("p", {}, button("logs.keep", keep, { id: "keep-map" }), " ", h("span", { class: "note" }, t("logs.keep.hint"))),
      words(state),
    ].flat().filter(Boolean);
  }

  function reason(channel, state) {
    if (chosenFor(channel, state).name) return t("logs.chosen");
    if (channel.taken) return t("logs.by_name");
    if (channel.guesses.length) return t("logs.may_be", { channels: channel.guesses.map((g) => t(`channel.${g}`)).join(", ") });
    return channel.constant ? t("logs.constant") : "";
  }

  function unitControl(channel, state) {
    const { name, unit } = chosenFor(channel, state);
    if (channel.unit && !unit) return channel.unit;
    const meant = name || channel.taken || channel.guesses[0] || "";
    return h("input", { type: "text", class: "short", value: unit, list: `units-${meant}`, "aria-label": `${channel.name}: ${t("unit")}`, maxlength: "40",
      onchange: (event) => attempt(() => take(channel, meant, event.target.value.trim())) });
  }

  function take(channel, value, unit = "") {
    return change((choices) => {
      const columns = { ...choices.columns };
      for (const [name, column] of Object.entries(columns)) {
        if (column === channel.name || column.startsWith(`${channel.name} [`)) delete columns[name];
      }
      if (value) columns[value] = unit ? `${channel.name} [${unit}]` : channel.name;
      return { columns };
    });
  }

  function words(state) {
    const put = (name) => (event) => attempt(() => change({ [name]: name === "rate" ? (event.target.value ? Number(event.target.value) : null) : event.target.value.trim() }));
    return h("details", { open: WORDS.some((w) => state.choices[w]) || null }, h("summary", {}, t("logs.more")),
      h("div", { class: "fields" }, WORDS.map((name) => field(`logs.${name}`, h("input", {
        type: name === "rate" ? "number" : "text", step: "any", value: state.choices[name] ?? "", onchange: put(name), maxlength: "100",
      }), t(`logs.${name}.hint`)))));
  }

  function update(state) {
    selected = Math.min(selected, Math.max(state.logs.length - 1, 0));
    fill(list, ...(state.logs.length ? [table(t("logs.title"), [t("logs.file"), t("logs.size"), t("logs.window"), ""],
      state.logs.map((log, k) => row(
        h("button", { type: "button", class: "link", "aria-pressed": String(k === selected), onclick: () => { selected = k; update(session.state); } }, log.name),
        `${number(log.size / 1e6, 3)} MB`,
        h("input", { type: "text", class: "short", placeholder: "10s:40s", value: state.choices.logs[k].window, "aria-label": `${log.name}: ${t("logs.window")}`,
          onchange: (event) => attempt(() => change(({ logs }) => ({ logs: logs.map((each, i) => (i === k ? { ...each, window: event.target.value.trim() } : each)) }))) }),
        button("remove", () => attempt(() => change(({ logs }) => ({ logs: logs.filter((_, i) => i !== k) }))), { "aria-label": `${t("remove")}: ${log.name}` }),
      )))] : []));
    const open = state.steps.find(({ name }) => name === "look");
    fill(next, open.lock ? "" : button("next.look", () => go("look"), { class: "main", id: "next" }));
    showChannels(state);
  }

  update(session.state);
  return { element, update };
}

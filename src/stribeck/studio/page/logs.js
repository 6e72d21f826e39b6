// Step 1: logs, and which column is which channel.

import { address, ask, change, get, post, session, settle } from "./api.js";
import { button, field, fill, h, menu, number, onward, patch, row, t, table, term } from "./dom.js";
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
// What the readers say of a log that cannot be read yet, and the same in the words of the page.
const LACKS = [
  [/^column (?<column>.+) is in (?<unit>\S+), which does not say of what/, "lacks.share"],
  [/^column (?<column>.+) has no unit/, "lacks.unit"],
  [/^columns? (?<columns>.+) without a unit/, "lacks.units"],
  [/^no (?<channel>\w+) column among /, "lacks.channel"],
];
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

// Where files are dropped, or chosen: all of it is the control.
export function dropZone(id, words, use) {
  const input = h("input", { type: "file", multiple: true, id, "aria-describedby": `${id}-hint`, onchange: (event) => attempt(async () => {
    const files = [...event.target.files];
    event.target.value = ""; // so that the same file can be chosen again, once it was undone
    await use(files);
  }) });
  const zone = h("div", {
    class: "drop",
    ondragover: (event) => { event.preventDefault(); zone.classList.add("over"); },
    ondragleave: () => zone.classList.remove("over"),
    ondrop: (event) => {
      event.preventDefault();
      zone.classList.remove("over");
      attempt(async () => use(await dropped(event.dataTransfer.items)));
    },
  }, h("label", { for: id }, words), h("span", { class: "choose", "aria-hidden": "true" }, t("logs.browse")), h("p", { class: "note", id: `${id}-hint` }, t("logs.formats")), input);
  return zone;
}

// The name of a kind of axis, as people say it.
export const rigTitle = (name) => term(`rig.${name}`, name);
// A comma before its decimals as a point: ranges are typed with either.
export const pointed = (text) => text.replace(/(\d),(\d)/g, "$1.$2");

export function logsStep() {
  const list = h("div");
  const channels = h("div", { id: "channels" });
  const zone = dropZone("files", t("logs.drop"), upload);
  const drive = h("div");
  const drawDrive = driveForm(drive);
  const next = onward();
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
      fill(channels, h("div", { class: "state warn", id: "unreadable" }, h("p", {}, error.message), h("p", {}, t("logs.unreadable"))));
      fill(drive);
      return;
    }
    if (key !== now) return;
    patch(channels, ...contentsView(contents, session.state));
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

  const named = (all) => Object.entries(all).map(([each, head]) => `${t(`channel.${each}`)} ← ${head}`).join(", ");

  // What a log is read as, and what of it is not taken though its name says what it is.
  function readAs(contents, state) {
    const taken = contents.channels.filter((channel) => channel.taken && channel.taken !== "time");
    const more = Object.entries(guessed(contents, state) ?? {}).filter(([name, head]) => !state.choices.columns[name] && contents.channels.every((channel) => channel.name !== head || !channel.taken));
    return h("div", { class: "state good", id: "read" },
      h("p", {}, t("logs.read", { channels: taken.map((channel) => t(`channel.${channel.taken}`)).join(", ") })),
      more.length > 0 && h("p", {}, button("logs.also", () => attempt(() => change({ columns: { ...state.choices.columns, ...Object.fromEntries(more) } })), { id: "also", class: more.some(([name]) => name === "force" || name === "current") ? "main" : null }), ` ${named(Object.fromEntries(more))}`));
  }

  function lack(text) {
    for (const [form, key] of LACKS) {
      const { groups } = form.exec(text) ?? {};
      if (groups) return t(key, groups.channel ? { channel: t(`channel.${groups.channel}`) } : groups);
    }
    return text;
  }

  function lacking(contents, state) {
    const [advice = ""] = ADVICE.exec(contents.lacking) ?? [];
    const [, name, column] = PROPOSED.exec(advice) ?? [];
    const proposed = !advice.includes("[drive]") && contents.channels.some((channel) => column?.startsWith(channel.name));
    const columns = /\bcolumn\b/.test(contents.lacking) && !advice.includes("[drive]") ? guessed(contents, state) : null;
    return h("div", { class: "state warn", id: "lacking" }, h("p", {}, lack(advice ? `${contents.lacking.replace(advice, "")}.` : contents.lacking)),
      contents.rig && h("p", {}, h("button", { type: "button", class: "main", id: "as-rig", onclick: () => attempt(() => change({ rig: contents.rig })) }, t("logs.as_rig", { rig: rigTitle(contents.rig) })), ` ${t("logs.heads")}`),
      columns && h("p", {}, button("logs.guess", () => attempt(() => change({ columns })), { class: contents.rig ? null : "main", id: "guess" }), ` ${named(columns)}`),
      !columns && proposed && h("p", {}, h("button", { type: "button", class: "main", id: "proposed", onclick: () => attempt(() => change(({ columns: now }) => ({ columns: { ...now, [name]: column } }))) },
        t("logs.proposed", { column, channel: t(`channel.${name}`) })), ` ${t("logs.or_unit")}`),
      advice.includes("[drive]") && h("p", {}, button("logs.drive", () => document.getElementById("drive-convention")?.focus(), { class: "main", id: "to-drive" })),
      !columns && advice && !proposed && !advice.includes("[drive]") && h("p", {}, t("logs.choose")));
  }

  function contentsView(contents, state) {
    const rows = contents.channels.map((channel) => ({ "data-key": channel.name, ...row(
      channel.name,
      unitControl(channel, state),
      number(channel.count, 9), channel.rate ? `${number(channel.rate)} Hz` : "–",
      menu([["", byName(channel, contents, state)], ...CHANNELS.map((c) => [c, t(`channel.${c}`)])], chosenFor(channel, state).name || channel.taken,
        (value) => attempt(() => take(channel, value, chosenFor(channel, state).unit)), { "aria-label": `${channel.name}: ${t("logs.taken")}` }),
      reason(channel, contents, state)) }));
    return [
      h("h2", {}, contents.file), h("p", {}, t("logs.format", { format: contents.format })),
      contents.lacking ? lacking(contents, state) : readAs(contents, state),
      contents.problems.length > 0 && h("ul", {}, contents.problems.map((p) => h("li", { lang: "en" }, p))),
      contents.kept && h("p", { class: "note" }, t("logs.as_kept")),
      table(t("logs.channels"), [t("logs.column"), t("unit"), t("logs.count"), t("logs.rate"), t("logs.taken"), t("logs.why")], rows),
      Object.entries(UNITS).map(([name, units]) => h("datalist", { id: `units-${name}` }, units.map((unit) => h("option", { value: unit })))),
      contents.mapped && !contents.kept && h("p", {}, button("logs.keep", keep, { id: "keep-map" }), " ", h("span", { class: "note" }, t("logs.keep.hint"))),
      words(state),
    ];
  }

  // What becomes of a column that nobody chooses: what its name and unit say, once the log can be read.
  function byName(channel, contents, state) {
    const name = contents.lacking && channel.unit && channel.guesses.find((guess) => !(guess in state.choices.columns));
    return name ? t("logs.not_yet", { channel: t(`channel.${name}`) }) : t("logs.not");
  }

  function reason(channel, contents, state) {
    if (chosenFor(channel, state).name) return t("logs.chosen");
    if (channel.taken && contents.as_rig) return t("logs.by_rig", { rig: rigTitle(contents.as_rig) });
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
    patch(list, ...(state.logs.length ? [table(t("logs.title"), [t("logs.file"), t("logs.size"), t("logs.window"), ""],
      state.logs.map((log, k) => ({ "data-key": log.id, ...row(
        h("button", { type: "button", class: "link", "aria-pressed": String(k === selected), onclick: () => { selected = k; update(session.state); } }, log.name),
        `${number(log.size / 1e6, 3)} MB`,
        h("input", { type: "text", class: "short", placeholder: t("logs.window.hint"), value: state.choices.logs[k].window, "aria-label": `${log.name}: ${t("logs.window")}`,
          onchange: (event) => attempt(() => change(({ logs }) => ({ logs: logs.map((each, i) => (i === k ? { ...each, window: pointed(event.target.value.trim()) } : each)) }))) }),
        button("remove", () => attempt(() => change(({ logs }) => ({ logs: logs.filter((_, i) => i !== k) }))), { "aria-label": `${t("remove")}: ${log.name}` }),
      ) })))] : []));
    const open = state.steps.find(({ name }) => name === "look");
    patch(next, open.lock ? "" : button("next.look", () => go("look"), { class: "main", id: "next" }));
    showChannels(state);
  }

  update(session.state);
  return { element, update };
}

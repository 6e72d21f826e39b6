// An axis by questions: which parts it has, and what is known of each of their coefficients.

import { OWN, change, rigNamed, session } from "./api.js";
import { field, fill, h, menu, patch, t, table } from "./dom.js";
import { attempt } from "./main.js";

const ONE = ["controller", "motor", "transmission"];
const SEVERAL = ["load", "sensor"];
const NUMBER = "[-+]?(?:\\d+\\.?\\d*|\\.\\d+)(?:[eE][-+]?\\d+)?";
const SINGLE = new RegExp(`^${NUMBER}$`);
const RANGE = new RegExp(`^(${NUMBER})\\s*:\\s*(${NUMBER})$`);
const COLUMN = new RegExp(`^column (.+) \\((${NUMBER})\\)$`);

// A coefficient as it is typed, and as a rig's file has it.
function written(value) {
  if (value === undefined) return "";
  if (value?.free) return value.free.join(":");
  if (value?.column) return `column ${value.column} (${value.value})`;
  return String(value);
}

function read(text) {
  if (SINGLE.test(text)) return Number(text);
  const range = RANGE.exec(text);
  if (range) return { free: [Number(range[1]), Number(range[2])] };
  const column = COLUMN.exec(text);
  return column ? { column: column[1], value: Number(column[2]) } : text;
}

export function composer(place) {
  const put = (more) => attempt(() => change(({ axis }) => {
    const changed = { ...axis, ...(typeof more === "function" ? more(axis) : more) };
    for (const [name, value] of Object.entries(changed)) if (value === undefined) delete changed[name];
    return { axis: changed };
  }));

  const parts = (role, rotary) => session.catalogue.parts.filter((part) => part.role === role && (part.rotary === null || part.rotary === rotary));

  // Which parts a turning or sliding axis cannot have goes; what it must have is the first of its role.
  const turned = (axis, rotary) => {
    const changed = { rotary };
    for (const role of [...ONE, ...SEVERAL]) {
      const there = parts(role, rotary).map(({ name }) => name);
      const kept = Object.fromEntries(Object.entries(axis[role] ?? {}).filter(([name]) => there.includes(name)));
      const needed = role !== "sensor" && !Object.keys(kept).length;
      changed[role] = needed ? { [there[0]]: {} } : kept;
    }
    return changed;
  };

  function choice(role, axis) {
    const chosen = Object.keys(axis[role] ?? {})[0] ?? parts(role, axis.rotary)[0].name;
    const part = parts(role, axis.rotary).find(({ name }) => name === chosen);
    return field(`ask.${role}`, menu(parts(role, axis.rotary).map(({ name, doc }) => [name, `${name}: ${doc}`]), chosen,
      (name) => put({ [role]: { [name]: {} }, ...(role === "transmission" && name !== "compliant" ? { friction: undefined } : {}) }), { id: `ask-${role}` }), part?.equation ?? "");
  }

  const several = (role, axis) => h("fieldset", {}, h("legend", {}, t(`ask.${role}`)), parts(role, axis.rotary).map(({ name, doc }) => h("label", { class: "check" },
    h("input", { type: "checkbox", id: `ask-${role}-${name}`, checked: name in (axis[role] ?? {}), onchange: (event) => put((now) => {
      const { [name]: was, ...rest } = now[role] ?? {};
      return { [role]: event.target.checked ? { ...rest, [name]: was ?? {} } : rest };
    }) }), `${name}: ${doc}`)));

  function coefficients(axis) {
    // A motor in front of a screw turns, whatever the axis does; its coefficients have the units of that.
    const turning = axis.rotary || parts("transmission", false).some(({ name, turns }) => turns && name in (axis.transmission ?? {}));
    const rows = [...ONE, ...SEVERAL].flatMap((role) => Object.entries(axis[role] ?? {}).flatMap(([name, stated]) => {
      const part = session.catalogue.parts.find((each) => each.role === role && each.name === name);
      return (part?.coefficients ?? []).map((c) => ({ "data-key": `${role} ${name} ${c.name}`, cells: [
        `${name}: ${c.name}`,
        h("input", { type: "text", class: "short", id: `part-${role}-${name}-${c.name}`, value: written(stated[c.name]), maxlength: "120", placeholder: c.idle ?? c.range, "aria-label": `${role} ${name}: ${c.name}`,
          onchange: (event) => {
            const text = event.target.value.trim();
            put((now) => {
              const { [c.name]: _, ...rest } = now[role][name];
              return { [role]: { ...now[role], [name]: text ? { ...rest, [c.name]: read(text) } : rest } };
            });
          } }),
        ((c.at_motor ? turning : axis.rotary) ? c.rotary_unit : c.unit) || "1", c.doc, state(stated[c.name], c),
      ] }));
    }));
    return rows.length > 0 && [h("p", { class: "note" }, t("ask.coefficients.hint")),
      table(t("ask.coefficients"), [t("axis.constant"), t("value"), t("unit"), t("meaning"), t("ask.status")], rows)];
  }

  function state(value, c) {
    if (value === undefined) return c.idle === null ? t("ask.identified", { range: c.range }) : t("ask.idle", { value: c.idle });
    if (value?.free) return t("ask.free");
    return value?.column ? t("ask.column") : t("origin.yours");
  }

  return function draw(now) {
    const { axis, rig } = now.choices;
    if (rig !== OWN) { fill(place); return; }
    if (axis.kind) { fill(place, h("p", { class: "note" }, t("axis.variant", { kind: axis.kind, doc: rigNamed(rig)?.doc ?? "" }))); return; }
    const rotary = axis.rotary === true;
    const whole = { ...axis, rotary };
    patch(place, h("h2", {}, t("ask.title")), h("div", { class: "fields" },
      field("ask.name", h("input", { type: "text", id: "ask-name", value: axis.name ?? "", maxlength: "60", placeholder: "axis", onchange: (event) => put({ name: event.target.value.trim() || undefined }) })),
      field("ask.motion", menu([["", t("ask.linear")], ["rotary", t("ask.rotary")]], rotary ? "rotary" : "", (value) => put((was) => turned(was, value === "rotary")), { id: "ask-motion" })),
      ONE.map((role) => choice(role, whole)),
      "compliant" in (axis.transmission ?? {}) && field("ask.friction", menu(["load", "motor", "both"].map((side) => [side, t(`side.${side}`)]), axis.friction?.side ?? "load", (side) => put({ friction: { side } }), { id: "ask-friction" }))),
    SEVERAL.map((role) => several(role, whole)), coefficients(whole));
  };
}

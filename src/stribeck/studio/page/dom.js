// Elements, and the words on them.

let words = {};

export async function speak(language) {
  words = await (await fetch(`/words/${language}.json`)).json();
  document.documentElement.lang = language;
}

// The words of a key, with values in the place of {names}.
export function t(key, values = {}) {
  const text = words[key] ?? key;
  return text.replace(/\{(\w+)\}/g, (_, name) => values[name] ?? "");
}

// The words of a key, or others where the catalogue has none: what a package declares elsewhere.
export const term = (key, otherwise) => words[key] ?? otherwise;

// An element: h("p", {class: "note", onclick: f}, "text", child).
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "value" || name === "checked" || name === "selected") element[name] = value;
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...shown(children));
  return element;
}

const shown = (children) => children.flat(4).filter((child) => child !== null && child !== undefined && child !== false && child !== "");

// Other children for an element; what is null, false or empty is none.
export const fill = (element, ...children) => element.replaceChildren(...shown(children));

// A button with words.
export const button = (key, onclick, attributes = {}) =>
  h("button", { type: "button", onclick, ...attributes }, t(key));

let count = 0;

// A label with its control below it, and a hint that screen readers read with it.
export function field(key, control, hint = "") {
  const id = control.id || `control-${++count}`;
  control.id = id;
  if (hint) control.setAttribute("aria-describedby", `${id}-hint`);
  return h("div", { class: "field" }, h("label", { for: id }, t(key)), control,
    hint && h("p", { class: "note", id: `${id}-hint` }, hint));
}

// A menu of [value, text] pairs.
export function menu(options, value, onchange, attributes = {}) {
  return h("select", { ...attributes, onchange: (event) => onchange(event.target.value) },
    options.map(([option, text]) => h("option", { value: option, selected: option === value }, text)));
}

// A table: heads and rows of texts or elements; the first cell of a row is its head.
export function table(caption, heads, rows, attributes = {}) {
  return h("div", { class: "cards" }, h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    h("table", attributes, h("caption", {}, caption),
      h("thead", {}, h("tr", {}, heads.map((head) => h("th", { scope: "col" }, head)))),
      h("tbody", {}, rows.map(({ cells, ...more }) => h("tr", more, cells.map((cell, k) =>
        k === 0 ? h("th", { scope: "row" }, cell) : h("td", { "data-head": heads[k] }, cell))))))));
}

// A number as people read it.
export function number(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

export const row = (...cells) => ({ cells });

// A unit as it is printed: `kg m**2` is `kg m²`.
export const printed = (unit) => unit.replaceAll("**2", "²").replaceAll("**3", "³");

// What leads on to the next step: in view whatever the length of the section that it ends.
export const onward = (...children) => h("div", { class: "onward" }, ...children);

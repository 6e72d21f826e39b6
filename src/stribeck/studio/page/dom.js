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
    if (name.startsWith("on")) hear(element, name.slice(2), value);
    else if (name === "value" || name === "checked" || name === "selected") element[name] = value;
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...shown(children));
  element.drawn = element.value;
  return element;
}

// One listener an event, whose function can be another later.
function hear(element, name, listener) {
  element.heard ??= {};
  if (!(name in element.heard)) element.addEventListener(name, (event) => element.heard[name]?.(event));
  element.heard[name] = listener;
}

// What is null, false or empty is not shown, and keeps its place among its siblings.
const shown = (children) => children.flat(4).map((child) => (child === null || child === undefined || child === false || child === "" ? document.createComment("") : child));

// Other children for an element.
export const fill = (element, ...children) => element.replaceChildren(...shown(children));

// As `fill`, and what is alike stays the element that it was: a press that began before it is a click yet,
// a focus, a text half typed and an open choice of files go on. What somebody is at stays where it is in the
// window, so that the next press meets it. For elements that nobody else holds; `data-key` tells members of
// a list apart.
export function patch(element, ...children) {
  const at = document.activeElement.closest("main *");
  const before = at?.getBoundingClientRect();
  merge(element, h("div", {}, ...children));
  if (at?.isConnected && before.bottom > 0 && before.top < innerHeight) putBack(at, before.top);
}

// An element where it was in the window, however much shorter the page is now.
function putBack(element, top) {
  const moved = () => element.getBoundingClientRect().top - top;
  scrollBy({ top: moved(), behavior: "instant" });
  if (moved() < 1) return;
  const main = element.closest("main");
  main.style.minHeight = `${main.offsetHeight + moved()}px`;
  scrollBy({ top: moved(), behavior: "instant" });
}

const keyOf = (node) => node.dataset?.key ?? "";
const alike = (one, other) => one.nodeName === other.nodeName && one.type === other.type && keyOf(one) === keyOf(other);

function merge(element, fresh) {
  let next = element.firstChild;
  for (const child of [...fresh.childNodes]) {
    let match = next;
    if (keyOf(child)) while (match && !alike(match, child)) match = match.nextSibling;
    if (!match || !alike(match, child)) { element.insertBefore(child, next); continue; }
    for (; next !== match; next = removed(next));
    next = match.nextSibling;
    if (match.nodeType === Node.ELEMENT_NODE) assign(match, child);
    else if (match.data !== child.data) match.data = child.data;
  }
  while (next) next = removed(next);
}

function removed(node) {
  const next = node.nextSibling;
  node.remove();
  return next;
}

function assign(element, fresh) {
  for (const { name } of [...element.attributes]) if (!fresh.hasAttribute(name) && name !== "open") element.removeAttribute(name);
  for (const { name, value } of fresh.attributes) if (element.getAttribute(name) !== value) element.setAttribute(name, value);
  for (const name of Object.keys(element.heard ?? {})) element.heard[name] = null;
  for (const [name, listener] of Object.entries(fresh.heard ?? {})) hear(element, name, listener);
  merge(element, fresh);
  if (element.type === "checkbox" || element.type === "radio") element.checked = fresh.checked;
  else if (element.matches("select") || (element.matches("input:not([type=file])") && !isHalfTyped(element))) element.value = fresh.value;
  element.drawn = fresh.drawn;
}

// Whether somebody is at a text and has changed it since it was drawn.
const isHalfTyped = (element) => element === document.activeElement && element.value !== element.drawn;

// A button with words.
export const button = (key, onclick, attributes = {}) =>
  h("button", { type: "button", onclick, ...attributes }, t(key));

let count = 0;

// A label with its control below it, and a hint that screen readers read with it.
export function field(key, control, hint = "") {
  const id = control.id || `control-${++count}`;
  control.id = id;
  if (hint) control.setAttribute("aria-describedby", `${id}-hint`);
  return h("div", { class: "field", "data-key": key }, h("label", { for: id }, t(key)), control,
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

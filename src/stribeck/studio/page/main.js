// The page: its head, its steps, and the step that its address names.

import { ask, called, follow, listen, post, session, settle } from "./api.js";
import { button, fill, h, menu, patch, speak, t } from "./dom.js";
import { axisStep } from "./axis.js";
import { fitStep } from "./fit.js";
import { dropZone, logsStep, upload } from "./logs.js";
import { lookStep } from "./look.js";
import { outStep } from "./out.js";
import { verdictStep } from "./verdict.js";

const STEPS = { logs: logsStep, look: lookStep, axis: axisStep, fit: fitStep, verdict: verdictStep, out: outStep };
const LANGUAGES = [["en", "English"], ["de", "Deutsch"], ["zh", "中文"]];

let language = localStorage.getItem("language")
  ?? (LANGUAGES.map(([code]) => code).find((code) => navigator.language.startsWith(code)) ?? "en");
let step = null;
let shown = null; // {step, update}

const place = (id) => document.getElementById(id);

// Another content for the page: what `patch` kept it high for is gone.
function stage(...children) {
  place("main").style.minHeight = "";
  fill(place("main"), ...children);
}

export function tell(text, kind = "note") {
  const told = place("told");
  fill(told, text ? h("p", { class: kind === "error" ? "state warn" : "state good" }, text,
    " ", h("button", { type: "button", class: "close", "aria-label": t("close"), onclick: () => tell("") }, "×")) : "");
}

// Runs what a person asked for; what cannot be done is said, and nothing is lost.
export async function attempt(work) {
  try {
    tell("");
    return await work();
  } catch (error) {
    tell(error.name === "TypeError" ? t("error.gone") : error.message, "error");
    if (session.id) try { settle(await ask("GET", `/api/sessions/${session.id}`)); } catch { /* said */ }
    return undefined;
  }
}

export function go(name) {
  history.pushState(null, "", `/s/${session.id}/${name}`);
  open();
}

function theme(value) {
  if (value) document.documentElement.dataset.theme = value;
  else delete document.documentElement.dataset.theme;
}

function isDark() {
  const stated = document.documentElement.dataset.theme;
  return stated ? stated === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

function drawHead() {
  const state = session.state;
  patch(place("head"), h("div", { class: "bar" },
    h("a", { href: "/", class: "home" }, "stribeck studio"),
    h("span", { class: "session" }, state ? called(state) || t("session.unnamed") : ""),
    h("div", { class: "tools" },
      state && button("undo", () => attempt(() => post("/undo")), { disabled: !state.undo, "aria-keyshortcuts": "Control+Z" }),
      state && button("redo", () => attempt(() => post("/redo")), { disabled: !state.redo, "aria-keyshortcuts": "Control+Y" }),
      menu(LANGUAGES, language, async (value) => {
        language = value;
        localStorage.setItem("language", value);
        await speak(value);
        redraw();
      }, { "aria-label": t("language") }),
      button(isDark() ? "theme.light" : "theme.dark", () => {
        const next = isDark() ? "light" : "dark";
        localStorage.setItem("theme", next);
        theme(next);
        redraw();
      }))));
  document.querySelector(".skip").textContent = t("skip");
  document.querySelector(".skip").href = "#main";
}

function drawSteps() {
  const state = session.state;
  place("steps").setAttribute("aria-label", t("steps"));
  patch(place("steps"), state ? h("ol", {}, state.steps.map(({ name, lock, detail }, k) => {
    const words = `${k + 1} ${t(`step.${name}`)}`;
    if (lock) {
      const reason = `${t(lock)}${detail ? `: ${detail}` : ""}`;
      return h("li", { class: "locked", title: reason }, h("button", { type: "button", "aria-disabled": "true", onclick: () => tell(`${t(`step.${name}`)}: ${reason}.`, "error") },
        words, h("span", { class: "hidden" }, `, ${t("locked")}: ${reason}`)));
    }
    return h("li", {}, h("a", {
      href: `/s/${state.id}/${name}`, "aria-current": name === step ? "step" : null,
      onclick: (event) => { event.preventDefault(); go(name); },
    }, words));
  })) : "");
}

function locked(entry) {
  return h("section", {}, h("h1", { tabindex: "-1" }, t(`step.${entry.name}`)),
    h("p", { class: "state warn" }, `${t(entry.lock)}${entry.detail ? `: ${entry.detail}` : ""}.`),
    h("p", {}, button("lock.back", () => go(firstOpen()))));
}

function firstOpen() {
  const steps = session.state.steps;
  const first = steps.findIndex((entry) => entry.lock);
  return steps[Math.max((first < 0 ? steps.length : first) - 1, 0)].name;
}

// Draws the step anew where it has changed, and else lets it bring itself up to date.
function render(anew = false) {
  drawHead();
  drawSteps();
  if (!session.state) return;
  const entry = session.state.steps.find(({ name }) => name === step);
  document.title = `${t(`step.${step}`)} – ${called(session.state) || "stribeck studio"}`;
  const key = `${step}/${entry.lock}/${entry.detail}`;
  if (!anew && shown?.key === key) { shown.update(session.state); return; }
  shown?.end?.();
  shown = { key, update: () => {} };
  if (entry.lock) { stage(locked(entry)); return; }
  const view = STEPS[step](session.state);
  shown = { key, update: view.update ?? (() => {}), end: view.end };
  stage(view.element);
}

const redraw = () => (session.state ? render(true) : open());

// A new session, with logs where some were dropped.
async function begin(name, files = []) {
  const { id } = await ask("POST", "/api/sessions", { name });
  history.pushState(null, "", `/s/${id}/logs`);
  await open();
  await upload(files);
}

async function home() {
  session.state = null;
  drawHead();
  fill(place("steps"));
  document.title = "stribeck studio";
  const sessions = await ask("GET", "/api/sessions");
  const name = h("input", { id: "name", type: "text", maxlength: "100", placeholder: t("session.name.hint") });
  stage(h("section", {},
    h("h1", { tabindex: "-1" }, t("home.title")), h("p", { class: "lead" }, t("home.lead")),
    dropZone("first-files", t("home.drop"), (files) => begin(name.value, files)),
    h("form", { class: "begin", onsubmit: (event) => {
      event.preventDefault();
      attempt(() => begin(name.value));
    } }, h("div", { class: "field" }, h("label", { for: "name" }, t("session.name")), name),
    h("button", { type: "submit" }, t("session.new"))),
    sessions.length > 0 && h("h2", {}, t("session.all")),
    h("ul", { class: "plain" }, sessions.map((entry) => h("li", {},
      h("a", { href: `/s/${entry.id}/logs` }, entry.name || t("session.unnamed")), " ",
      h("span", { class: "note" }, entry.created.slice(0, 16)))))));
}

async function open() {
  const [, marker, id, name] = location.pathname.split("/");
  if (marker !== "s") { await home(); return; }
  step = name in STEPS ? name : "logs";
  if (session.id !== id || !session.state) {
    shown = null;
    const followed = await attempt(async () => { await follow(id); return true; });
    if (!followed) { stage(h("p", {}, h("a", { href: "/" }, t("home.back")))); return; }
  }
  render(shown?.key.split("/")[0] !== step);
  document.querySelector("main h1")?.focus();
}

listen(() => { if (step) render(); });
addEventListener("popstate", open);
addEventListener("keydown", (event) => {
  const typing = event.target.closest?.("input, textarea, select");
  if (!event.ctrlKey || typing || !session.state) return;
  if (event.key === "z" && session.state.undo) { event.preventDefault(); attempt(() => post("/undo")); }
  if (event.key === "y" && session.state.redo) { event.preventDefault(); attempt(() => post("/redo")); }
});

theme(localStorage.getItem("theme"));
await speak(language);
session.catalogue = await ask("GET", "/api/catalogue");
await open();

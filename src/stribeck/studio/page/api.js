// What the studio answers, and the session as it stands.

export const session = { id: null, state: null, catalogue: null };
const listeners = new Set();
let source = null;

// The session's own axis among the rigs.
export const OWN = "axis.toml";
export const rigNamed = (name) => (name === OWN ? session.state.axis : session.catalogue.rigs[name]);

export const listen = (listener) => listeners.add(listener);

// What is said to the person when something could not be done.
export class Refusal extends Error {}

export async function ask(method, path, body, more = {}) {
  const options = { method, ...more };
  if (body !== undefined) options.body = body instanceof Blob ? body : JSON.stringify(body);
  const response = await fetch(path, options);
  const text = await response.text();
  let answer = null;
  try { answer = JSON.parse(text); } catch { answer = { error: text.trim() }; }
  if (!response.ok) throw new Refusal(answer.error ?? String(response.status));
  return answer;
}

// Fits are counted in their session; the numbers of jobs count what nobody sees as well.
export const fitNumber = (id) => session.state.jobs.filter((job) => job.kind === "identify").findIndex((job) => job.id === id) + 1;
// What a session is called: as it was named, or after its first log.
export const called = (state) => state.name || state.logs[0]?.name || "";

export const address = (rest = "") => `/api/sessions/${session.id}${rest}`;
export const get = (rest) => ask("GET", address(rest));

export function settle(state) {
  const before = session.state;
  session.state = state;
  for (const listener of listeners) listener(state, before);
}

let last = Promise.resolve();
let waiting = 0; // changes that are not answered yet

// Changes some choices, one after the other: what is typed quickly does not meet itself halfway.
// Of a function, what it says of the choices as they are when its turn comes.
export function change(choices) {
  waiting += 1;
  const next = last.then(async () => {
    const changes = typeof choices === "function" ? choices(session.state.choices) : choices;
    let state = null;
    try { state = await ask("PATCH", address(), { choices: changes, step: session.state.step }); } finally { waiting -= 1; }
    // With another behind it, it would show for a moment what is not chosen any more.
    if (waiting) session.state = state;
    else settle(state);
  });
  last = next.catch(() => {});
  return next;
}

export async function post(rest, body = {}) {
  const answer = await ask("POST", address(rest), body);
  if (answer.steps) settle(answer);
  return answer;
}

// Follows a session: other windows, and workers, change it too.
export async function follow(id) {
  session.id = id;
  settle(await get(""));
  connect();
}

// Only a window in view listens: a browser has six connections to a host, whatever the windows.
function connect() {
  source?.close();
  if (document.hidden || !session.id) return;
  source = new EventSource(address("/events"));
  source.onmessage = (event) => {
    const state = JSON.parse(event.data);
    if (waiting) return;
    if (JSON.stringify(state) !== JSON.stringify(session.state)) settle(state);
  };
}

document.addEventListener("visibilitychange", connect);

// What the studio answers, and the session as it stands.

export const session = { id: null, state: null, catalogue: null };
const listeners = new Set();
let source = null;

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

export const address = (rest = "") => `/api/sessions/${session.id}${rest}`;
export const get = (rest) => ask("GET", address(rest));

export function settle(state) {
  const before = session.state;
  session.state = state;
  for (const listener of listeners) listener(state, before);
}

let last = Promise.resolve();

// Changes some choices, one after the other: what is typed quickly does not meet itself halfway.
// Of a function, what it says of the choices as they are when its turn comes.
export function change(choices) {
  const next = last.then(async () => {
    const changes = typeof choices === "function" ? choices(session.state.choices) : choices;
    settle(await ask("PATCH", address(), { choices: changes, step: session.state.step }));
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
    if (JSON.stringify(state) !== JSON.stringify(session.state)) settle(state);
  };
}

document.addEventListener("visibilitychange", connect);

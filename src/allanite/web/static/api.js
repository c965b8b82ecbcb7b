// The server: every request of the page goes through here.

export class Refusal extends Error {
  constructor({ error, option = null, exit = null, cure = "", columns = null }) {
    super(error);
    Object.assign(this, { option, exit, cure, columns });
  }
}

async function answer(response) {
  if (response.ok) return response.status === 204 ? null : response.json();
  let told;
  try {
    told = await response.json();
  } catch {
    told = { error: `${response.status} ${response.statusText}` };
  }
  throw new Refusal({ ...told, error: told.error ?? `${response.status} ${response.statusText}` });
}

/** The secret of the server is known to this origin alone, whose port a cookie would not tell apart from others. */
const signed = (secret = localStorage.getItem("secret") ?? "") => ({ Authorization: `Bearer ${secret}` });

const fetched = (path, options = {}, secret = undefined) => fetch(path, { credentials: "omit", ...options, headers: { ...signed(secret), ...options.headers } });

const ask = async (path, options, secret) => answer(await fetched(path, options, secret));

const sent = (method, body) => ({
  method,
  headers: { "Content-Type": "application/json" },
  body: JSON.stringify(body ?? {}),
});

/** Exchange the token of the link for the secret; a link that was used opens where the secret is known already. */
export async function enter() {
  const asked = new URLSearchParams(location.hash.slice(1));
  const token = asked.get("token");
  if (token === null) return;
  history.replaceState(null, "", `#${asked.get("workspace") ?? ""}`);
  const { secret } = await ask("/api/enter", { method: "POST" }, token).catch(async (error) => {
    await workspaces().catch(() => { throw error; });
    return { secret: localStorage.getItem("secret") };
  });
  localStorage.setItem("secret", secret);
}

export function query(path, values) {
  const params = new URLSearchParams();
  for (const [key, value] of Object.entries(values)) if (value !== undefined && value !== null && value !== "") params.set(key, value);
  return `${path}?${params}`;
}

export const tables = (lang) => ask(query("/api/tables", { lang }));
export const workspaces = () => ask("/api/workspaces");
export const newWorkspace = () => ask("/api/workspaces", sent("POST"));
export const workspace = (id) => ask(`/api/workspaces/${id}`);
export const dropWorkspace = (id) => ask(`/api/workspaces/${id}`, { method: "DELETE" });
export const keepChoices = (id, choices) => ask(`/api/workspaces/${id}/choices`, sent("PUT", choices));
export const openPath = (id, path) => ask(`/api/workspaces/${id}/open`, sent("POST", { path }));
export const example = (id, name) => ask(`/api/workspaces/${id}/example`, sent("POST", { name }));
export const forget = (id, file) => ask(`/api/workspaces/${id}/files/${file}`, { method: "DELETE" });
export const start = (id, order) => ask(`/api/workspaces/${id}/jobs`, sent("POST", order));
export const cancel = (id) => ask(`/api/jobs/${id}/cancel`, sent("POST"));
export const trace = (file, window, signal) => ask(query(`/api/files/${file}/trace`, window), { signal });
export const job = (id, lang) => ask(query(`/api/jobs/${id}`, { lang }));
export const deviation = (id, channel, statistic, lang) => ask(query(`/api/jobs/${id}/deviation`, { channel, statistic, lang }));
export const refit = (id, order, signal) => ask(`/api/jobs/${id}/refit`, { ...sent("POST", order), signal });
export const exported = (id, order) => ask(`/api/jobs/${id}/export`, sent("POST", order));

/** A file of a result, with its name. */
export async function saved(id, form, more = {}) {
  const response = await fetched(query(`/api/jobs/${id}/save`, { form, ...more }));
  if (!response.ok) await answer(response);
  return { blob: await response.blob(), name: /filename="(.*)"/.exec(response.headers.get("Content-Disposition"))[1] };
}

/** Send a file; `told` hears the share that is sent. */
export function upload(id, file, told) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", query(`/api/workspaces/${id}/files`, { name: file.name }));
    request.setRequestHeader("Authorization", signed().Authorization);
    request.responseType = "text";
    request.upload.onprogress = (event) => event.lengthComputable && told(event.loaded / event.total);
    request.onerror = () => reject(new Refusal({ error: `${file.name}: the server does not answer` }));
    request.onload = () => answer(new Response(request.responseText, { status: request.status, statusText: request.statusText })).then(resolve, reject);
    request.send(file);
  });
}

const LAST = ["done", "failed"];

const AGAIN = 3000; // ms until a stream that broke off is asked for once more

/** Events of a stream that the server sends: name and data of each. */
async function* told(body) {
  const reader = body.pipeThrough(new TextDecoderStream()).getReader();
  for (let rest = ""; ;) {
    const { done, value } = await reader.read();
    if (done) return;
    const pieces = (rest + value).split("\n\n");
    rest = pieces.pop();
    for (const piece of pieces) {
      const [, name, data] = /^event: (\w+)\ndata: (.*)$/.exec(piece) ?? [];
      if (name) yield [name, JSON.parse(data)];
    }
  }
}

/** Events of a job until it ends, which `heard` is told; the stream is asked for again if the server is away for a moment. */
export async function events(id, heard) {
  for (;;) {
    const response = await fetched(`/api/jobs/${id}/events`).catch(() => null);
    if (response && !response.ok) return heard("away", { closed: true });
    const coming = response && told(response.body);
    for (let next; coming && (next = await coming.next().catch(() => null)) && !next.done;) {
      heard(...next.value);
      if (LAST.includes(next.value[0])) return null;
    }
    heard("away", { closed: false });
    await new Promise((resolve) => { setTimeout(resolve, AGAIN); });
  }
}

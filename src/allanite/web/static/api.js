// The server: every request of the page goes through here.

export class Refusal extends Error {
  constructor({ error, option = null, exit = null }) {
    super(error);
    this.option = option;
    this.exit = exit;
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

async function ask(path, options = {}) {
  return answer(await fetch(path, { credentials: "same-origin", ...options }));
}

const sent = (method, body) => ({
  method,
  headers: { "Content-Type": "application/json" },
  body: JSON.stringify(body ?? {}),
});

export function query(path, values) {
  const params = new URLSearchParams();
  for (const [key, value] of Object.entries(values)) if (value !== undefined && value !== null && value !== "") params.set(key, value);
  return `${path}?${params}`;
}

export const tables = (lang) => ask(query("/api/tables", { lang }));
export const newWorkspace = () => ask("/api/workspaces", sent("POST"));
export const workspace = (id) => ask(`/api/workspaces/${id}`);
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
export const saved = (id, form, more = {}) => query(`/api/jobs/${id}/save`, { form, ...more });

/** Send a file; `told` hears the share that is sent. */
export function upload(id, file, told) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", query(`/api/workspaces/${id}/files`, { name: file.name }));
    request.responseType = "text";
    request.upload.onprogress = (event) => event.lengthComputable && told(event.loaded / event.total);
    request.onerror = () => reject(new Refusal({ error: `${file.name}: the server does not answer` }));
    request.onload = () => answer(new Response(request.responseText, { status: request.status, statusText: request.statusText })).then(resolve, reject);
    request.send(file);
  });
}

/** Events of a job until it ends; the browser connects again by itself if the server is away for a moment. */
export function events(id, heard) {
  const source = new EventSource(`/api/jobs/${id}/events`);
  for (const name of ["progress", "trace", "curves", "words", "live", "done", "failed"])
    source.addEventListener(name, (event) => {
      if (name === "done" || name === "failed") source.close();
      heard(name, event.data ? JSON.parse(event.data) : {});
    });
  source.onerror = () => heard("away", { closed: source.readyState === EventSource.CLOSED });
  return source;
}

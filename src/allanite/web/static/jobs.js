// Jobs: start, progress, cancel, and what went wrong.

import * as api from "./api.js";
import { button, byId, el, fill, show } from "./dom.js";
import { choose, run, state, tell } from "./state.js";
import { t } from "./words.js";

const running = new Map();

export const busy = () => running.size > 0;

function draw() {
  const rows = [...running.values()].map((one) => {
    const done = one.fraction === undefined || one.fraction === null ? null : Math.round(100 * one.fraction);
    return el("li", {},
      el("span", { test: "progress-what" }, one.what),
      el("progress", { max: 100, value: done ?? undefined, "aria-label": one.what, test: "progress" }),
      button(t("cancel"), "cancel", one.stop, { class: "small" }));
  });
  fill(byId("progress"), rows);
  show(byId("progress"), rows.length > 0);
  document.body.classList.toggle("busy", rows.length > 0);
  tell("busy");
}

export function progress(key, what, fraction, stop) {
  if (what === null) running.delete(key);
  else running.set(key, { what, fraction, stop: stop ?? running.get(key)?.stop ?? (() => {}) });
  draw();
}

export function cancelAll() {
  for (const one of running.values()) one.stop();
}

/** Start a job and wait for its result; `heard` is told of events of a live job. */
export async function perform(verb, files, recipe, heard = () => {}, more = {}) {
  return follow(await start(verb, files, recipe, more), verb, heard);
}

/** Start a job. */
export async function start(verb, files, recipe, more = {}) {
  const { job } = await api.start(state.workspace, { verb, files, recipe, lang: state.choices.lang ?? "en", ...more });
  state.jobs.push({ id: job, verb, files, recipe, state: "running" });
  if (verb === "analyze") choose({ pending: job }, true);
  return job;
}

/** Wait for a job that runs, maybe since before a reload. */
export function follow(job, verb, heard = () => {}) {
  return new Promise((resolve, reject) => {
    const row = state.jobs.find((one) => one.id === job) ?? {};
    const end = (name, act) => {
      row.state = name;
      progress(job, null);
      act();
    };
    const load = () => api.job(job, state.choices.lang).then((value) => resolve(remember(job, value)), reject);
    const ends = {
      done: () => end("done", load),
      failed: (told) => end(stopped(told) ? "cancelled" : "failed", () => reject(stopped(told) ? new Cancelled() : new api.Refusal(told))),
    };
    progress(job, t(verb), null, () => api.cancel(job).catch((error) => tell("error", error)));
    api.events(job, (name, told) => {
      if (name in ends) ends[name](told);
      else if (name === "progress") progress(job, told.word ? t(told.word) : (told.what ?? t(verb)), told.fraction);
      else if (name === "trace" && told.problem) tell("error", new api.Refusal(told.problem));
      else if (name === "trace") tell("readable", files(job));
      else if (name === "curves") tell("early", { file: files(job)[0], curves: told.channels });
      else if (name !== "away") heard(name, told);
      else if (told.closed) api.job(job).then((value) => settled(value, ends), (error) => end("lost", () => reject(error)));
      else progress(job, t("away"), null);
    });
  });
}

const stopped = (told) => told.error === "cancelled";

const files = (job) => state.jobs.find((one) => one.id === job)?.files ?? [];

/** A job that the user ended: nothing to say. */
export class Cancelled extends Error {}

/** The stream of events is closed for good: what the server says of the job decides. */
function settled(value, ends) {
  const act = ends[value.state] ?? ends.failed;
  act(value.problem ?? { error: value.state === "cancelled" ? value.state : t("lost") });
}

export function remember(job, value) {
  state.results[job] = value;
  return value;
}

export async function result(job) {
  return state.results[job] ?? remember(job, await api.job(job, state.choices.lang));
}

/** The job that is shown, if it is finished. */
export const shown = () => (run() ? state.results[run()] : undefined);

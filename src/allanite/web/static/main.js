// The page: loads what is kept, joins the parts, and analyzes what is dropped.

import * as api from "./api.js";
import * as columns from "./columns.js";
import * as compare from "./compare.js";
import * as controls from "./controls.js";
import * as curves from "./curves.js";
import * as files from "./files.js";
import * as fit from "./fit.js";
import * as jobs from "./jobs.js";
import * as keys from "./keys.js";
import * as live from "./live.js";
import * as output from "./output.js";
import * as results from "./results.js";
import * as selection from "./selection.js";
import * as theme from "./theme.js";
import * as trace from "./trace.js";
import { byId } from "./dom.js";
import { choose, keep, load, on, pending, recipe, redo, run, state, tell, undo } from "./state.js";
import { t } from "./words.js";

let turn = 0;

/** Analyze the file that is shown; what an earlier question answers late is not shown. */
async function analyze() {
  const file = state.choices.file;
  if (!file) return;
  const mine = ++turn;
  controls.clearErrors();
  try {
    const job = await jobs.start("analyze", [file], recipe(file));
    await jobs.follow(job, "analyze");
    if (mine === turn) finished(file, job);
  } catch (error) {
    if (mine === turn && !(error instanceof jobs.Cancelled)) tell("error", Object.assign(error, { file }));
    if (mine === turn) choose({ pending: null }, true);
    throw error;
  }
}

const tried = () => analyze().catch(() => {});

const written = (values) => JSON.stringify(Object.entries(values ?? {}).sort());

/** An analysis with the same choices would repeat what is shown. */
function enable() {
  const job = state.jobs.find((one) => one.id === run());
  const same = jobs.shown() && !state.choices.stale && written(job?.recipe) === written(recipe());
  byId("analyze").disabled = !state.choices.file || jobs.busy() || Boolean(same);
}

/** The analysis is done: what lay over the curve is shown of the new run. */
function finished(file, job) {
  const before = `${state.choices.runs?.[file]}/`;
  const over = (state.choices.over ?? []).map((one) => (one.startsWith(before) ? `${job}/${one.slice(before.length)}` : one));
  choose({ over, runs: { ...state.choices.runs, [file]: job }, pending: null, stale: null }, true);
  controls.refresh();
  tell("result", job);
}

/** Make the analysis agree with the choices, if terms or band were fitted again since. */
async function renew() {
  if (state.choices.stale) await analyze();
}

/** Go on with a job that ran when the page was closed. */
async function resume() {
  const { pending: job, file } = state.choices;
  if (!job) return;
  try {
    await jobs.follow(job, "analyze");
    finished(file, job);
  } catch (error) {
    choose({ pending: null }, true);
    if (!(error instanceof jobs.Cancelled)) tell("error", error);
  }
}

/** The sheets that are shown, in the language chosen. */
async function speakResults() {
  const job = state.choices.runs?.[state.choices.file];
  if (!job || !jobs.shown()) return;
  const made = await api.job(job, state.choices.lang).catch((error) => tell("error", error));
  if (made) {
    jobs.remember(job, made);
    tell("result", job);
  }
}

const KEYS = [
  ["o", "choose", () => byId("choose-file").click()],
  ["x", "example", () => byId("examples").querySelector("button")?.click()],
  ["a", "analyze", () => byId("analyze").click()],
  ["Escape", "cancel", () => jobs.cancelAll()],
  ["u", "undo", () => selection.back(undo)],
  ["Ctrl+z", null, () => selection.back(undo)],
  ["r", "redo", () => selection.back(redo)],
  ["Ctrl+y", null, () => selection.back(redo)],
  ["c", "cut", () => selection.cut()],
  ["m", "mask", () => selection.mask()],
  ["w", "whole", () => trace.look()],
  ["+", "zoom", () => trace.move(0.5)],
  ["-", null, () => trace.move(2)],
  ["ArrowLeft", null, () => trace.move(1, -0.25)],
  ["ArrowRight", null, () => trace.move(1, 0.25)],
  ["v", "select", () => trace.setMode("select")],
  ["z", "zoom", () => trace.setMode("zoom")],
  ["s", "statistic", () => curves.step(1)],
  ["S", null, () => curves.step(-1)],
  ["b", "bands", () => byId("bands").click()],
  ["f", "residuals", () => byId("residuals").click()],
  ["y", "overlay", () => curves.overlayAll()],
  ["g", "guide", () => byId("guide-add").click()],
  ["n", "channel", () => nextChannel()],
  ["e", "export", () => output.exportNow()],
  ["d", "theme", () => theme.turn()],
];

function nextChannel() {
  const names = (jobs.shown()?.channels ?? []).map((one) => one.name);
  const at = names.indexOf(curves.front()?.name);
  if (names.length) choose({ channel: names[(at + 1) % names.length] });
}

async function begin() {
  await api.enter();
  const asked = new URLSearchParams(location.search).get("lang");
  await load(asked ?? localStorage.getItem("lang"));
  state.choices.lang ??= asked ?? state.tables.first?.lang ?? "en";
  await theme.setLanguage(state.choices.lang);
  on("language", (lang) => { localStorage.setItem("lang", lang); controls.build(); speakResults(); if (!run() && !jobs.busy()) tried(); });
  on("error", (error) => controls.refuse(error));
  on("file", tried);
  on("altered", tried);
  addEventListener("pagehide", () => pending() && keep());
  addEventListener("hashchange", () => location.reload()); // another place where work is kept
  for (const part of [files, columns, trace, selection, curves, fit, results, compare, live, theme]) part.start();
  byId("side-fold").open = matchMedia("(min-width: 56rem)").matches;
  controls.build();
  output.start(renew);
  keys.start(KEYS);
  byId("analyze").addEventListener("click", tried);
  for (const name of ["choices", "result", "shown", "busy", "refit"]) on(name, enable);
  enable();
  for (const note of state.tables.first?.notes ?? []) tell("error", new Error(note));
  await restore();
}

async function restore() {
  await curves.restore();
  state.choices.file ??= state.files.at(-1)?.id ?? null;
  if (!state.choices.file) return;
  files.draw();
  controls.refresh();
  tell("shown", state.choices.file);
  if (jobs.shown()) tell("result", state.choices.runs[state.choices.file]);
  if (state.choices.pending) await resume();
  else if (!jobs.shown()) await tried();
}

begin().then(() => { document.body.dataset.ready = "true"; }, (error) => controlsless(error));

/** Nothing works without the tables and the place where work is kept: say why. */
function controlsless(error) {
  const place = byId("problem");
  place.textContent = error.message;
  place.hidden = false;
  document.body.dataset.ready = "false";
  console.error(error, t("lost"));
}

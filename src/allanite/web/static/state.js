// What is chosen: one plain object, kept by the server so that a reload or a crash loses nothing.

import * as api from "./api.js";

const bus = new EventTarget();
const LIMIT = 100;

export const state = { tables: null, workspace: null, files: [], jobs: [], results: {}, choices: {} };

const past = [];
const future = [];
let timer = null;

export const on = (name, heard) => bus.addEventListener(name, (event) => heard(event.detail));
export const tell = (name, detail) => bus.dispatchEvent(new CustomEvent(name, { detail }));

/** Change choices and keep them. */
export function choose(patch, silent = false) {
  Object.assign(state.choices, patch);
  clearTimeout(timer);
  timer = setTimeout(keep, 150);
  document.body.dataset.kept = "no";
  if (!silent) tell("choices", patch);
}

export function keep() {
  clearTimeout(timer);
  timer = null;
  return api.keepChoices(state.workspace, state.choices).then(() => { if (!pending()) document.body.dataset.kept = "yes"; }, (error) => tell("error", error));
}

export const pending = () => timer !== null;

/** The recipe of the file that is shown. */
export const recipe = (file = state.choices.file) => state.choices.recipes?.[file] ?? {};

const snapshot = () => JSON.stringify({ file: state.choices.file, recipe: recipe() });

function put(values, file = state.choices.file) {
  const kept = Object.fromEntries(Object.entries(values).filter(([, value]) => value !== "" && value !== null && value !== undefined));
  choose({ recipes: { ...state.choices.recipes, [file]: kept } });
}

/** Change keys of the recipe; a step that can be undone. Empty values go back to what the file says. */
export function alter(patch) {
  past.push(snapshot());
  if (past.length > LIMIT) past.shift();
  future.length = 0;
  put({ ...recipe(), ...patch });
  tell("history");
}

function step(from, to) {
  if (!from.length) return false;
  to.push(snapshot());
  const { file, recipe: values } = JSON.parse(from.pop());
  choose({ file });
  put(values, file);
  tell("history");
  return true;
}

export const undo = () => step(past, future);
export const redo = () => step(future, past);
export const depth = () => ({ undo: past.length, redo: future.length });

/** Pieces cut out of the record: pairs of seconds. */
export function cuts() {
  const text = recipe().exclude ?? "";
  return text ? text.split(",").map((piece) => piece.split("..").map(Number)) : [];
}

export const fileOf = (id) => state.files.find((file) => file.id === id);
export const run = () => state.choices.runs?.[state.choices.file];

/** Load the workspace in the address, the last one used here or anywhere, or a new one. */
export async function load(lang) {
  state.tables = await api.tables(lang);
  const wanted = location.hash.slice(1) || state.tables.first?.workspace || localStorage.getItem("workspace") || (await api.workspaces())[0]?.id;
  const whole = wanted ? await api.workspace(encodeURIComponent(wanted)).catch(() => null) : null;
  const id = whole?.id ?? (await api.newWorkspace()).id;
  state.workspace = id;
  localStorage.setItem("workspace", id);
  history.replaceState(null, "", `#${id}`);
  Object.assign(state, { files: whole?.files ?? [], jobs: whole?.jobs ?? [], choices: whole?.choices ?? {} });
}

// Files: dropped, chosen, opened by path, or an example.

import * as api from "./api.js";
import { button, byId, el, fill } from "./dom.js";
import { busy, progress } from "./jobs.js";
import { choose, fileOf, on, run, state, tell } from "./state.js";
import { t } from "./words.js";

const size = (bytes) => {
  if (bytes === undefined || bytes === null) return "";
  const power = Math.min(3, Math.floor(Math.log10(Math.max(bytes, 1)) / 3));
  return `${Number((bytes / 1000 ** power).toPrecision(3))} ${["B", "kB", "MB", "GB"][power]}`;
};

function added(file) {
  if (!state.files.some((one) => one.id === file.id)) state.files.push(file);
  show(file.id);
  tell("file", file.id);
}

/** Make a file the one that is shown. */
export function show(id) {
  choose({ file: id, window: null, channel: null });
  draw();
  byId("open-fold").open = state.files.length === 0;
  tell("shown", id);
}

/** Come back to a file, which is analyzed if it never was. */
function visit(id) {
  show(id);
  if (id && !run()) tell("file", id);
}

/** A file that cannot be analyzed: why, and the ways on from it; one that could not be read is not kept. */
async function fail({ file, words, unreadable }) {
  if (unreadable) await remove(file, () => choose({ file: null }));
  byId("failed-words").textContent = words;
  const others = state.files.filter((one) => one.id !== file).slice(-3);
  fill(byId("failed-ways"), button(t("choose"), "failed-choose", () => byId("choose-file").click()),
    others.map((one) => button(`${t("back")} ${one.name}`, "failed-back", () => visit(one.id))),
    fileOf(file) ? button(`${t("remove")} ${fileOf(file).name}`, "failed-remove", () => remove(file)) : []);
  byId("failed").hidden = false;
  byId("open-fold").open = true;
}

async function guarded(act) {
  try {
    await act();
  } catch (error) {
    tell("error", error);
  }
}

async function send(file) {
  progress(file, `${t("upload")}: ${file.name}`, 0);
  await guarded(async () => added(await api.upload(state.workspace, file, (share) => progress(file, `${t("upload")}: ${file.name}`, share))));
  progress(file, null);
}

async function several(list) {
  for (const file of list) await send(file);
}

const openPath = (path) => guarded(async () => added(await api.openPath(state.workspace, path)));

export const tryExample = (name) => guarded(async () => added(await api.example(state.workspace, name)));

async function remove(id, then = () => visit(state.files.at(-1)?.id ?? null)) {
  await guarded(async () => {
    await api.forget(state.workspace, id);
    state.files = state.files.filter((file) => file.id !== id);
    const { [id]: _, ...runs } = state.choices.runs ?? {};
    choose({ runs });
    then();
    draw();
  });
}

/** Work that cannot be read any more: its files still take room. */
function damaged({ id, bytes }) {
  const drop = () => guarded(async () => {
    await api.dropWorkspace(id);
    state.tables.first.aside = state.tables.first.aside.filter((one) => one.id !== id);
    draw();
  });
  return el("li", { test: "damaged" }, t("damaged"), el("span", { class: "quiet" }, size(bytes)),
    button("×", "damaged-remove", drop, { class: "small", "aria-label": `${t("remove")} ${t("damaged")}` }));
}

export function draw() {
  const rows = state.files.map((file) => {
    const current = file.id === state.choices.file;
    return el("li", { class: current ? "current" : "" },
      button(file.name, "file", () => visit(file.id), { class: "plain", "aria-current": current ? "true" : null, title: file.path ?? file.name }),
      el("span", { class: "quiet" }, size(file.bytes)),
      button("×", "file-remove", () => remove(file.id), { class: "small", "aria-label": `${t("remove")} ${file.name}` }));
  });
  fill(byId("files"), rows, (state.tables.first?.aside ?? []).map(damaged));
  document.body.classList.toggle("empty", !state.choices.file);
}

function examples() {
  const rows = state.tables.examples ?? [];
  fill(byId("examples"), rows.map((row) => button(rows.length === 1 ? t("example") : (row.title ?? row.name ?? row), "example", () => tryExample(row.name ?? row), { title: row.title ?? "" })));
}

function dropping() {
  const mark = (yes) => document.body.classList.toggle("dropping", yes);
  addEventListener("dragover", (event) => { event.preventDefault(); mark(true); });
  addEventListener("dragleave", (event) => event.relatedTarget === null && mark(false));
  addEventListener("drop", (event) => {
    event.preventDefault();
    mark(false);
    several([...event.dataTransfer.files]);
  });
}

export function start() {
  dropping();
  const path = byId("open-path");
  const openable = () => { byId("open-form").querySelector("button").disabled = path.value.trim() === ""; };
  path.addEventListener("input", openable);
  openable();
  on("failed", fail);
  for (const name of ["shown", "busy"]) on(name, () => { if (name === "shown" || busy()) byId("failed").hidden = true; });
  byId("choose-file").addEventListener("change", (event) => several([...event.target.files]).then(() => { event.target.value = ""; }));
  byId("open-form").addEventListener("submit", (event) => {
    event.preventDefault();
    openPath(path.value.trim());
  });
  on("language", () => { examples(); draw(); });
  examples();
  draw();
}

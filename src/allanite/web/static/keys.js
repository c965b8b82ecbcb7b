// Keyboard: one key for each thing that is done often; "?" lists them.

import { byId, el, fill } from "./dom.js";
import { t } from "./words.js";

/** Rows: key, word, act. */
let rows = [];

const written = (event) => (event.ctrlKey || event.metaKey ? "Ctrl+" : "") + event.key;

const typing = (node) => node.matches?.("input:not([type=checkbox]), select, textarea") ?? false;

function pressed(event) {
  if (event.altKey || byId("keys").open || (typing(event.target) && event.key !== "Escape")) return;
  const row = rows.find(([key]) => key === written(event));
  if (!row) return;
  event.preventDefault();
  row[2]();
}

export function list() {
  const box = byId("keys");
  const table = rows.filter(([, word]) => word).map(([key, word]) => [el("dt", {}, el("kbd", {}, key)), el("dd", {}, t(word))]);
  fill(byId("keys-list"), table.flat());
  box.showModal();
}

export function start(given) {
  rows = [...given, ["?", "keys", list]];
  addEventListener("keydown", pressed);
  byId("help").addEventListener("click", list);
  byId("keys-close").addEventListener("click", () => byId("keys").close());
}

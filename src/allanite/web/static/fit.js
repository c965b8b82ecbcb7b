// Terms and band of the model, fitted again at once.

import * as api from "./api.js";
import { byId, el, fill } from "./dom.js";
import { front, hueOf, paint, put, statistic } from "./curves.js";
import { shown } from "./jobs.js";
import { alter, on, recipe, run, state, tell } from "./state.js";
import { t } from "./words.js";

let asking = null;
let fits = {};

const ofFront = () => {
  const one = front();
  return one ? (fits[`${one.job}/${one.name}`] ?? shown()?.value?.channels?.find((each) => each.name === one.name)?.fit) : null;
};

const FOUND = ["identified", "weak", "reported"];

/** Terms that the fit may find: those it looked for, or those that are wanted. */
function symbols() {
  const wanted = recipe().terms;
  if (wanted && wanted !== "auto") return wanted.includes(",") ? wanted.split(",") : known(wanted);
  return (ofFront()?.terms ?? []).map((one) => one.symbol);
}

/** Symbols written one after another: the longest that fits each time. */
function known(text) {
  const names = state.tables.terms.map((one) => one.symbol).sort((a, b) => b.length - a.length);
  const found = [];
  for (let rest = text; rest;) {
    const name = names.find((one) => rest.startsWith(one)) ?? rest[0];
    if (names.includes(name)) found.push(name);
    rest = rest.slice(name.length);
  }
  return found;
}

function draw() {
  const active = new Set(symbols());
  const found = new Set((ofFront()?.terms ?? []).filter((one) => FOUND.includes(one.status)).map((one) => one.symbol));
  const boxes = (rows) => rows.map((row) => {
    const letter = el("strong", {}, row.symbol);
    letter.style.color = hueOf(row);
    const box = el("input", { type: "checkbox", checked: active.has(row.symbol), test: `term-${row.symbol}`, onchange: (event) => toggle(row.symbol, event.target.checked) });
    const how = found.has(row.symbol) ? "found" : active.has(row.symbol) ? "allowed" : null;
    const mark = el("span", { class: "mark", test: `mark-${row.symbol}`, ...(how ? { role: "img", "aria-label": t(how) } : {}) }, { found: "●", allowed: "○" }[how] ?? "");
    mark.style.color = hueOf(row);
    return el("label", { class: "term", title: row.title ?? "" }, box, mark, letter, el("span", { class: "quiet" }, row.title ?? ""));
  });
  const first = (row) => (row.automatic && row.slope !== null) || found.has(row.symbol);
  fill(byId("terms"), boxes(state.tables.terms.filter(first)));
  fill(byId("terms-more"), boxes(state.tables.terms.filter((row) => !first(row))));
  const { band, terms } = recipe();
  byId("fit-auto").disabled = !band && !terms;
  const scope = ofFront()?.scope?.band ?? [];
  for (const [i, id] of [[0, "band-low"], [1, "band-high"]]) {
    byId(id).value = Array.isArray(band) ? band[i] : "";
    byId(id).placeholder = scope[i] === undefined || scope[i] === null ? "" : Number(scope[i].toPrecision(4));
  }
}

export function toggle(symbol, yes) {
  const names = new Set(symbols());
  if (yes ?? !names.has(symbol)) names.add(symbol);
  else names.delete(symbol);
  const ordered = state.tables.terms.map((one) => one.symbol).filter((one) => names.has(one));
  return change({ terms: ordered.length ? ordered.join(",") : "" });
}

function limits() {
  const [low, high] = ["band-low", "band-high"].map((id) => (byId(id).value === "" ? Number(byId(id).placeholder) : Number(byId(id).value)));
  const none = byId("band-low").value === "" && byId("band-high").value === "";
  return change({ band: none ? "" : [low, high] });
}

function change(patch) {
  alter(patch);
  return again();
}

/** Fit again with the recipe as it is; only the answer to the last question counts. */
export async function again() {
  const one = front();
  if (!one) return;
  asking?.abort();
  asking = new AbortController();
  const { signal } = asking;
  const { terms = "auto", band = "auto" } = recipe();
  try {
    const made = await api.refit(one.job, { channel: one.name, terms, band, statistics: [statistic()], lang: state.choices.lang }, signal);
    fits[`${one.job}/${one.name}`] = made.fit;
    for (const curve of made.curve) put(one.job, one.name, curve);
    state.choices.stale = run();
    tell("refit", { channel: one.name, ...made });
    draw();
    await paint();
    byId("curve-plot").dataset.refits = Number(byId("curve-plot").dataset.refits ?? 0) + 1;
  } catch (error) {
    if (error.name !== "AbortError") tell("error", error);
  }
}

export function start() {
  for (const id of ["band-low", "band-high"]) byId(id).addEventListener("change", limits);
  byId("fit-auto").addEventListener("click", () => change({ terms: "", band: "" }));
  on("result", () => { fits = {}; draw(); });
  on("language", draw);
  on("theme", draw);
  on("choices", (patch) => { if (patch.recipes || "channel" in patch) draw(); });
}

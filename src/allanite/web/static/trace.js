// The record in time: least and greatest value of every pixel, read again for each window that is looked at.

import * as api from "./api.js";
import { button, byId, el, fill, menu, show } from "./dom.js";
import { shown } from "./jobs.js";
import { CONFIG, axis, between, color, digits, draw, layout, literal, series } from "./plots.js";
import { plain, spoken } from "./naming.js";
import { choose, cuts, on, run, state, tell } from "./state.js";
import { t } from "./words.js";

const SETTINGS = { ...CONFIG, edits: {}, doubleClick: false };

/** Files that were read, so that their samples can be asked for. */
const readable = new Set();
export const legible = (file) => readable.has(file);

let data = null;
let mode = "zoom";
let asking = null;
let listening = false;
let taken = null;

const place = () => byId("trace-plot");
export const duration = () => data?.duration ?? data?.t?.at(-1) ?? 0;
export const known = () => Boolean(data) && !data.raw.includes("rate");
export const outlying = () => data?.outlier_count > 0;
export const channel = () => state.choices.channel ?? data?.channel ?? null;

function findings() {
  const result = shown();
  const own = result?.channels?.find((one) => one.name === channel()) ?? result?.channels?.[0];
  const each = [...(result?.findings ?? []), ...(own?.findings ?? [])].sort((a, b) => Boolean(b.at) - Boolean(a.at)); // first what happened
  return each.map((one) => ({ ...one, text: spoken(one.text), level: one.level ?? "note" }));
}

const hue = (level) => color(level === "alert" ? "--alarm" : level === "fair" ? "--fair" : "--soft");

function strips() {
  const strip = (x0, x1, fillcolor, more = {}) => ({ type: "rect", xref: "x", yref: "paper", x0, x1, y0: 0, y1: 1, fillcolor, line: { width: 0 }, layer: "below", ...more });
  const found = findings().filter((one) => one.at).map((one) => strip(one.at[0], one.at[1], hue(one.level), { opacity: 0.12 }));
  const gaps = (data.gaps ?? []).map(([a, b]) => strip(a, b, color("--line"), { opacity: 0.8 }));
  const out = cuts().map(([a, b]) => strip(a, b, color("--ground"), { opacity: 0.75, layer: "above", line: { width: 1, color: color("--alarm"), dash: "dot" } }));
  const chosen = state.selection ? [strip(...state.selection, color("--link"), { opacity: 0.18 })] : [];
  return [...gaps, ...found, ...out, ...chosen];
}

function traces() {
  const main = series(0);
  const [low, high] = between(data.t, data.low, data.high, main, 0.55, channel());
  const line = { width: 1, color: main };
  const marks = { x: data.outliers ?? [], y: (data.outliers ?? []).map(() => 0.02), yaxis: "y2", mode: "markers", name: t("outliers"), marker: { symbol: "triangle-up", size: 7, color: color("--alarm") }, hovertemplate: "%{x:.6g} s<extra></extra>" };
  const located = findings().filter((one) => one.at);
  const notes = { x: located.map((one) => (one.at[0] + one.at[1]) / 2), y: located.map(() => 0.97), yaxis: "y2", mode: "markers", marker: { symbol: "triangle-down", size: 9, color: located.map((one) => hue(one.level)) }, text: located.map((one) => literal(one.text, 400)), hovertemplate: "%{text}<extra></extra>" };
  return [{ ...low, line, hoverinfo: "x+y" }, { ...high, line, hoverinfo: "x+y" }, marks, notes, ...beyond().traces];
}

/** Stretches that reach beyond the range drawn: a mark at its edge for each, and the farthest of them. */
function beyond() {
  if (!data.range) return { traces: [], far: [] };
  const sides = [["low", 0, "triangle-down", (value) => value < data.range[0]], ["high", 1, "triangle-up", (value) => value > data.range[1]]];
  const far = [];
  const traces = sides.map(([side, end, symbol, out]) => {
    const places = data[side].flatMap((value, i) => (value !== null && out(value) ? [i] : []));
    const values = places.map((i) => data[side][i]);
    if (values.length) far.push((end ? Math.max : Math.min)(...values));
    return { x: places.map((i) => data.t[i]), y: places.map(() => data.range[end]), text: values.map(digits), mode: "markers", cliponaxis: false, marker: { symbol, size: 9, color: color("--alarm") }, hovertemplate: `%{x:.6g}: %{text} ${data.unit}<extra></extra>` };
  });
  return { traces, far };
}

/** What the eye cannot see: that the numbers have no unit yet, and how far some of them are. */
function captions() {
  const { far } = beyond();
  show(byId("raw"), data.raw.length > 0);
  byId("raw").textContent = `${t("rawnote")} ${data.raw.map(plain).join(", ")}`;
  show(byId("beyond"), far.length > 0);
  byId("beyond").textContent = `${t("beyond")} ${far.map((value) => `${digits(value)} ${data.unit}`.trim()).join(", ")}`;
}

function paint() {
  if (!data) return;
  const window = state.choices.window;
  const form = layout({
    height: 260,
    dragmode: mode === "zoom" ? "zoom" : "select",
    selectdirection: "h",
    selections: [],
    xaxis: axis(t(known() ? "time" : "count"), { range: window ?? [0, duration()] }),
    yaxis: axis(data.unit || t("raw"), { fixedrange: true, ...(data.range ? { range: data.range, autorange: false } : { autorange: true }) }),
    yaxis2: { overlaying: "y", range: [0, 1], fixedrange: true, visible: false },
    shapes: strips(),
    uirevision: state.choices.file,
  });
  draw(place(), traces(), form, SETTINGS);
  captions();
  byId("whole").disabled = !window;
  place().dataset.points = data.t.length;
  listen();
}

function listen() {
  if (listening) return;
  listening = true;
  place().on("plotly_relayout", (event) => {
    const range = event["xaxis.range"] ?? (event["xaxis.range[0]"] !== undefined ? [event["xaxis.range[0]"], event["xaxis.range[1]"]] : null);
    if (range) look(Number(range[0]), Number(range[1]));
  });
  place().on("plotly_doubleclick", () => look());
  place().on("plotly_selected", (event) => event?.range?.x && take(event.range.x.map(Number).sort((a, b) => a - b)));
}

/** A piece is drawn; the library says it again whenever the chart is drawn. */
function take(range) {
  if (String(range) === taken) return;
  taken = String(range);
  tell("selected", [Math.max(0, range[0]), Math.min(duration(), range[1])]);
}

/** Look at a window, in seconds; at the whole record without one. */
export function look(from, until) {
  const window = from === undefined ? null : [Math.max(0, from), Math.min(duration(), until)];
  choose({ window }, true);
  return load();
}

/** Closer or farther by a factor, or aside by a share of the window. */
export function move(factor, aside = 0) {
  const [a, b] = state.choices.window ?? [0, duration()];
  const middle = (a + b) / 2 + aside * (b - a);
  const half = Math.min(((b - a) / 2) * factor, duration() / 2);
  const from = Math.min(Math.max(0, middle - half), duration() - 2 * half);
  return look(from, from + 2 * half);
}

export async function load() {
  const file = state.choices.file;
  const known = Boolean(file) && (readable.has(file) || Boolean(run()));
  show(byId("trace-section"), known);
  if (!known) return;
  asking?.abort();
  asking = new AbortController();
  const [from, to] = state.choices.window ?? [];
  try {
    data = await api.trace(file, { channel: state.choices.channel, from, to, points: Math.max(400, 2 * Math.round(place().clientWidth)) }, asking.signal);
  } catch (error) {
    if (error.name !== "AbortError") show(byId("trace-section"), false);
    return;
  }
  names();
  paint();
  tell("traced");
}

function names() {
  const list = data.channels ?? shown()?.channels?.map((one) => one.name) ?? [];
  fill(byId("channel"), menu(list, channel()));
}

export function notes() {
  const rows = findings().map((one) => el("li", { class: one.level, test: "finding" },
    one.at ? button(one.text, "finding-place", () => look(...around(one.at)), { class: "plain" }) : el("span", {}, one.text)));
  fill(byId("findings"), rows);
  paint();
}

const around = ([a, b]) => [a - (b - a) / 2 - 1, b + (b - a) / 2 + 1];

export function setMode(wanted) {
  mode = wanted;
  for (const one of ["zoom", "select"]) byId(`mode-${one}`).setAttribute("aria-pressed", String(one === mode));
  paint();
}

export function start() {
  byId("channel").addEventListener("change", (event) => choose({ channel: event.target.value }));
  byId("mode-zoom").addEventListener("click", () => setMode("zoom"));
  byId("mode-select").addEventListener("click", () => setMode("select"));
  byId("whole").addEventListener("click", () => look());
  on("shown", () => { data = null; load(); });
  on("choices", (patch) => { if ("channel" in patch && data) load().then(notes); else if (data) paint(); });
  on("selection", paint);
  on("theme", paint);
  on("readable", (files) => {
    for (const file of files) readable.add(file);
    if (files.includes(state.choices.file)) load();
  });
  on("result", () => load().then(notes));
}

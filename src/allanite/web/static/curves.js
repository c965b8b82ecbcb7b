// Deviation against averaging time: the channel that is looked at, and whatever lies over it.

import * as api from "./api.js";
import { byId, el, fill, menu, show } from "./dom.js";
import { result } from "./jobs.js";
import { labels } from "./labels.js";
import { at, axis, between, color, dark, draw, layout, literal, log, series, written } from "./plots.js";
import { choose, fileOf, on, run, state, tell } from "./state.js";
import * as guides from "./guides.js";
import { t } from "./words.js";

const NARROW = 480; // pixels of a chart whose legend has short names
const GAP = 26; // pixels between panels, and of the panels themselves: one alone, of several, of the residuals
const [ALONE, SEVERAL, LOWER] = [330, 240, 120];
const LETTER = 6.5; // pixels of a letter of an axis
const RATIOS = [1 / 3, 3]; // what the residuals are drawn between

const cache = new Map();
let listening = false;

const place = () => byId("curve-plot");
const axisOf = (i) => `y${i ? i + 1 : ""}`;
const key = (job, channel) => `${job}/${channel}`;
export const statistic = () => state.choices.statistic ?? "oadev";

/** Channels of the last analysis of each file. */
export const rows = () => state.files.flatMap(({ id }) => {
  const job = state.choices.runs?.[id];
  return (state.results[job]?.channels ?? []).map(({ name }) => ({ job, name, file: id }));
});

/** The channel in front: its model, terms and guides are shown. */
export function front() {
  const own = rows().filter((one) => one.job === run());
  return own.find((one) => one.name === state.choices.channel) ?? own[0] ?? null;
}

export function put(job, channel, curve) {
  cache.set(`${key(job, channel)}/${curve.statistic ?? statistic()}`, curve);
}

async function curveOf(one) {
  const known = `${key(one.job, one.name)}/${statistic()}`;
  if (!cache.has(known)) cache.set(known, await api.deviation(one.job, one.name, statistic(), state.choices.lang));
  return cache.get(known);
}

const chosen = () => {
  const first = front();
  const over = new Set(state.choices.over ?? []);
  return rows().filter((one) => first && (one === first || (one.job === first.job && one.name === first.name) || over.has(key(one.job, one.name))));
};

export const hueOf = (row) => (row ? (dark() ? row.dark : row.color) : null) ?? color("--soft");
const termOf = (symbol) => state.tables.terms.find((one) => one.symbol === symbol);
const modelled = (curve) => (state.choices.model === false ? [] : [...(curve.terms ?? []), ...(curve.model ? [curve.model] : [])]);

/** What is told of a point: its value, its interval and its model. */
const told = (curve, name) => curve.tau.map((tau, i) => [
  `${name}<br>${written(tau)} s: ${written(curve.deviation[i])} ${curve.unit}`,
  curve.low && curve.low[i] !== null ? `${curve.interval}: ${written(curve.low[i])} … ${written(curve.high[i])}` : "",
  curve.model ? `${t("model")}: ${written(at(curve.model.tau, curve.model.deviation, tau))}` : "",
].filter(Boolean).join("<br>"));

/** A curve with its band, and with its terms and its model if it is in front; `alone` has them in the legend. */
function lines(curve, one, { index = 0, first = true, yaxis = "y", alone = true, files = 1 } = {}) {
  const hue = series(index);
  const narrow = place().clientWidth < NARROW;
  const own = { x: curve.tau, yaxis, mode: "lines" };
  const name = literal(one.name || fileOf(one.file)?.name || "") + (files > 1 ? ` (${literal(fileOf(one.file)?.name ?? "", 30)})` : "");
  const band = state.choices.bands !== false && curve.low ? between(curve.tau, curve.low, curve.high, hue, first ? 0.2 : 0.1, curve.interval).map((each) => ({ ...each, yaxis, showlegend: alone && !narrow && Boolean(each.fill) })) : [];
  const drawn = [...band, { ...own, y: curve.deviation, mode: "lines+markers", marker: { size: 4 }, line: { color: hue, width: first ? 2 : 1.3 }, name, text: told(curve, name), hovertemplate: "%{text}<extra></extra>" }];
  if (!first || state.choices.model === false) return drawn;
  for (const term of curve.terms ?? [])
    drawn.push({ ...own, x: term.tau, y: term.deviation, line: { color: hueOf(termOf(term.symbol)), width: 1.2, dash: "dash" }, showlegend: alone, name: narrow ? term.symbol : `${term.symbol} ${term.title}`, hovertemplate: `${term.symbol} = ${term.coefficient}<br>%{x:.4g} s: %{y:.4g} ${curve.unit}<extra></extra>` });
  if (curve.model) drawn.push({ ...own, x: curve.model.tau, y: curve.model.deviation, line: { color: color("--ink"), width: 1.4 }, name: t("model"), legendrank: 2000, hovertemplate: `${t("model")}: %{y:.4g} ${curve.unit}<extra></extra>` });
  return drawn;
}

/** Deviation over model; what is beyond the axis is marked at its edge. */
function ratios(curve, yaxis) {
  if (!curve.model || state.choices.residuals !== true) return [];
  const [low, high] = RATIOS;
  const over = (values) => values.map((value, i) => value / at(curve.model.tau, curve.model.deviation, curve.tau[i]));
  const within = (values) => values.map((value) => Math.min(Math.max(value, low), high));
  const shares = over(curve.deviation);
  const symbol = shares.map((value) => (value < low ? "triangle-down" : value > high ? "triangle-up" : "circle"));
  const band = curve.low ? between(curve.tau, within(over(curve.low)), within(over(curve.high)), series(0), 0.2, "").map((each) => ({ ...each, yaxis })) : [];
  return [...band, { x: curve.tau, y: within(shares), yaxis, text: shares.map(written), mode: "lines+markers", cliponaxis: false, marker: { symbol, size: symbol.map((one) => (one === "circle" ? 4 : 8)) }, line: { color: series(0), width: 1.3 }, name: t("residuals"), showlegend: false, hovertemplate: "%{x:.4g} s: %{text}<extra></extra>" }];
}

/** What is in sight, in decades: room below for the lines of the terms; the last limits of the band are not worth theirs. */
function ranges(curves, first) {
  const good = (values) => values.filter((value) => value > 0);
  const tau = curves.flatMap((one) => one.tau);
  const heights = good(curves.flatMap((one) => one.deviation));
  const top = Math.max(...heights, ...good(modelled(first).includes(first.model) ? first.model.deviation : []));
  const decades = (values, below, above) => [Math.log10(Math.min(...values) / below), Math.log10(Math.max(...values) * above)];
  return { x: decades(tau, 1.4, 1.4), y: decades([...heights, top], modelled(first).length ? 6 : 2, 2) };
}

/** The title of an axis: the quantity with its unit, by its short name where there is no room. */
function quantity({ title, statistic: name, unit }, room) {
  const whole = `${title.charAt(0).toUpperCase()}${title.slice(1)} (${unit})`;
  return whole.length * LETTER > room ? `${name} (${unit})` : whole;
}

/** Panels from above: one for each unit, and the residuals; each with its axis, its part of the height, and pixels. */
function panels(units, lower) {
  const sizes = [...units.map(() => (units.length > 1 ? SEVERAL : ALONE)), ...(lower ? [LOWER] : [])];
  const whole = sizes.reduce((sum, size) => sum + size + GAP, -GAP);
  const above = sizes.map((_, i) => sizes.slice(0, i).reduce((sum, size) => sum + size + GAP, 0));
  return { whole, rows: sizes.map((size, i) => ({ axis: axisOf(i), size, domain: [Math.max(0, 1 - (above[i] + size) / whole), 1 - above[i] / whole] })) };
}

function form(curves, first) {
  const units = [...new Set(curves.map((one) => one.unit))];
  const lower = ratios(first).length > 0;
  const { whole, rows: each } = panels(units, lower);
  const shown = units.map((unit) => curves.filter((one) => one.unit === unit));
  const lead = units.indexOf(first.unit);
  const sights = shown.map((own, i) => ranges(own, i === lead ? first : {}));
  const x = ranges(curves, {}).x;
  const seen = { x, y: sights[lead].y, size: [Math.max(200, place().clientWidth - 80), each[lead].size], yref: each[lead].axis };
  const named = modelled(first).filter((term) => term.number).map((term) => ({ x: term.tau, y: term.deviation, text: `${term.symbol} ${term.number}`, color: hueOf(termOf(term.symbol)) }));
  const others = [...shown[lead].map((one) => ({ x: one.tau, y: one.deviation })), ...(first.model ? [{ x: first.model.tau, y: first.model.deviation }] : [])];
  const axes = each.map(({ axis: name, domain, size }, i) => [name.replace("y", "yaxis"), i < units.length
    ? log(quantity(shown[i][0], size), { domain, range: sights[i].y })
    : axis(`${t("deviation")} / ${t("model")}`, { domain, type: "log", range: RATIOS.map(Math.log10), tickvals: [1 / 3, 0.5, 1, 2, 3], ticktext: ["1/3", "1/2", "1", "2", "3"] })]);
  return layout({
    height: whole + 110,
    showlegend: true,
    xaxis: log(t("tau"), { anchor: each.at(-1).axis, range: x }),
    ...Object.fromEntries(axes),
    shapes: guides.shapes(first, seen.yref),
    annotations: labels([...named, ...guides.lines(first)], others, seen),
    uirevision: `${statistic()} ${state.choices.file} ${units}`,
  });
}

/** Everything again: what is known is not asked twice. */
export async function paint() {
  const first = front();
  show(byId("curve-section"), Boolean(first));
  if (!first) return;
  const wanted = chosen();
  let curves;
  try {
    curves = await Promise.all(wanted.map(curveOf));
  } catch (error) {
    tell("error", Object.assign(error, { option: error.option ?? "statistic" }));
    return;
  }
  const lead = wanted.findIndex((one) => one.job === first.job && one.name === first.name);
  const units = [...new Set(curves.map((one) => one.unit))];
  const files = new Set(wanted.map((one) => one.file)).size;
  const drawn = curves.flatMap((curve, i) => lines(curve, wanted[i], { index: i, first: i === lead, yaxis: axisOf(units.indexOf(curve.unit)), alone: curves.length === 1, files }));
  await draw(place(), [...drawn, ...ratios(curves[lead], axisOf(units.length))], form(curves, curves[lead]));
  for (const id of ["model", "residuals"]) byId(id).disabled = !curves[lead].model;
  byId("bands").disabled = !curves.some((one) => one.low);
  Object.assign(place().dataset, { curves: curves.length, statistic: statistic(), validity: curves[lead].validity ?? "" });
  guides.list(curves[lead]);
  listen(curves[lead]);
  legend(wanted);
  tell("front", curves[lead]);
}

/** The curve of a file of which nothing else is known yet: without band and model, which need the fit. */
async function early({ file, curves }) {
  const first = curves.find((one) => one.name === state.choices.channel) ?? curves[0];
  if (!first || front() || file !== state.choices.file) return;
  show(byId("curve-section"), true);
  await draw(place(), lines(first, { name: first.name, file }), form([first], first));
  place().dataset.early = first.name;
}

function listen() {
  if (listening) return;
  listening = true;
  place().on("plotly_relayout", (event) => front() && guides.dragged(event, cache.get(`${key(front().job, front().name)}/${statistic()}`)) && paint());
}

function legend(wanted) {
  const names = new Set(wanted.map((one) => key(one.job, one.name)));
  const lead = front();
  const several = new Set(rows().map((one) => one.file)).size > 1;
  const items = rows().map((one) => {
    const id = key(one.job, one.name);
    const index = wanted.findIndex((each) => key(each.job, each.name) === id);
    const swatch = el("span", { class: "swatch" });
    if (index >= 0) swatch.style.background = series(index);
    const own = id === key(lead.job, lead.name);
    const box = el("input", { type: "checkbox", checked: names.has(id), disabled: own, test: "over", onchange: (event) => toggle(id, event.target.checked) });
    return el("li", {}, el("label", {}, box, swatch, one.name, ...(several ? [" ", el("span", { class: "quiet" }, fileOf(one.file)?.name ?? "")] : [])));
  });
  fill(byId("over"), items);
  const own = rows().filter((one) => one.job === run()).map((one) => key(one.job, one.name));
  byId("over-all").disabled = own.every((id) => names.has(id));
}

function toggle(id, yes) {
  const over = new Set(state.choices.over ?? []);
  if (yes) over.add(id);
  else over.delete(id);
  choose({ over: [...over] });
}

export const overlayAll = () => choose({ over: rows().filter((one) => one.job === run()).map((one) => key(one.job, one.name)) });

export function step(by) {
  const names = state.tables.statistics.map((row) => row.name ?? row);
  choose({ statistic: names[(names.indexOf(statistic()) + by + names.length) % names.length] });
}

function controls() {
  fill(byId("statistic"), menu(state.tables.statistics, statistic()));
  for (const id of ["bands", "model", "residuals"]) byId(id).checked = id === "residuals" ? state.choices[id] === true : state.choices[id] !== false;
}

export function start() {
  byId("statistic").addEventListener("change", (event) => choose({ statistic: event.target.value }));
  for (const id of ["bands", "model", "residuals"]) byId(id).addEventListener("change", (event) => choose({ [id]: event.target.checked }));
  byId("over-all").addEventListener("click", overlayAll);
  on("choices", (patch) => {
    controls();
    if (["statistic", "bands", "model", "residuals", "over", "channel", "guides", "runs"].some((one) => one in patch)) paint();
  });
  for (const name of ["result", "theme", "shown"]) on(name, paint);
  on("early", early);
  on("language", () => { controls(); paint(); });
  controls();
}

/** Results of earlier analyses, for what lies over the curve. */
export async function restore() {
  for (const job of Object.values(state.choices.runs ?? {})) await result(job).catch((error) => tell("error", error));
}

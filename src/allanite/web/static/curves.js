// Deviation against averaging time: the channel that is looked at, and whatever lies over it.

import * as api from "./api.js";
import { byId, el, fill, menu, show } from "./dom.js";
import { result } from "./jobs.js";
import { labels } from "./labels.js";
import { at, axis, beside, between, color, dark, draw, layout, literal, log, series } from "./plots.js";
import { choose, fileOf, on, run, state, tell } from "./state.js";
import * as guides from "./guides.js";
import { t } from "./words.js";

const NARROW = 480; // pixels of a chart whose legend has short names

const cache = new Map();
let listening = false;

const place = () => byId("curve-plot");
const key = (job, channel) => `${job}/${channel}`;
export const statistic = () => state.choices.statistic ?? "oadev";

/** Channels of all finished analyses, as they can be shown. */
export function rows() {
  const found = [];
  for (const { id, files } of state.jobs.filter((one) => one.verb === "analyze" && state.results[one.id]))
    for (const one of state.results[id].channels ?? [])
      found.push({ job: id, name: one.name, file: one.file ?? files?.[0], run: id });
  return found;
}

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

function lines(curve, one, index, first, yaxis) {
  const hue = series(index);
  const own = { x: curve.tau, yaxis, mode: "lines" };
  const name = literal(one.name);
  const label = `${name} (${literal(fileOf(one.file)?.name ?? "")})`;
  const narrow = place().clientWidth < NARROW;
  const band = state.choices.bands !== false && curve.low ? between(curve.tau, curve.low, curve.high, hue, first ? 0.2 : 0.1, curve.interval).map((each) => ({ ...each, yaxis, showlegend: first && Boolean(each.fill) })) : [];
  const drawn = [...band, { ...own, y: curve.deviation, mode: "lines+markers", marker: { size: 4 }, line: { color: hue, width: first ? 2 : 1.3 }, name: narrow ? name : label, hovertemplate: `${label}<br>%{x:.4g} s: %{y:.4g} ${curve.unit}<extra></extra>` }];
  if (!first || state.choices.model === false) return drawn;
  for (const term of curve.terms ?? [])
    drawn.push({ ...own, x: term.tau, y: term.deviation, line: { color: hueOf(termOf(term.symbol)), width: 1.2, dash: "dash" }, name: narrow ? term.symbol : `${term.symbol} ${term.title}`, hovertemplate: `${term.symbol} = ${term.coefficient}<br>%{x:.4g} s: %{y:.4g} ${curve.unit}<extra></extra>` });
  if (curve.model) drawn.push({ ...own, x: curve.model.tau, y: curve.model.deviation, line: { color: color("--ink"), width: 1.4 }, name: t("model"), hovertemplate: `${t("model")}: %{y:.4g} ${curve.unit}<extra></extra>` });
  return drawn;
}

function ratios(curve) {
  if (!curve.model || state.choices.residuals !== true) return [];
  const over = (values) => values.map((value, i) => value / at(curve.model.tau, curve.model.deviation, curve.tau[i]));
  const own = { xaxis: "x", yaxis: "y3" };
  const band = curve.low ? between(curve.tau, over(curve.low), over(curve.high), series(0), 0.2, "").map((each) => ({ ...each, ...own })) : [];
  return [...band, { ...own, x: curve.tau, y: over(curve.deviation), mode: "lines+markers", marker: { size: 4 }, line: { color: series(0), width: 1.3 }, name: t("residuals"), showlegend: false, hovertemplate: "%{y:.3f}<extra></extra>" }];
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

function form(curves, first, units) {
  const lower = ratios(first).length > 0;
  const domain = lower ? [0.34, 1] : [0, 1];
  const height = lower ? 560 : 440;
  const own = curves.filter((each) => each.unit === units[0]);
  const seen = { ...ranges(own, first), size: [Math.max(200, place().clientWidth - 80), (lower ? 0.66 : 1) * (height - 110)] };
  const named = modelled(first).filter((term) => term.number).map((term) => ({ x: term.tau, y: term.deviation, text: `${term.symbol} ${term.number}`, color: hueOf(termOf(term.symbol)) }));
  const others = [...own.map((each) => ({ x: each.tau, y: each.deviation })), ...(first.model ? [{ x: first.model.tau, y: first.model.deviation }] : [])];
  return layout({
    height,
    showlegend: true,
    xaxis: log(t("tau"), { anchor: lower ? "y3" : "y", range: seen.x }),
    yaxis: log(units[0], { domain, range: seen.y }),
    ...beside(units[1], { domain }),
    ...(lower ? { yaxis3: axis(`${t("deviation")} / ${t("model")}`, { domain: [0, 0.26] }) } : {}),
    shapes: guides.shapes(first),
    annotations: [...guides.labels(first), ...labels(named, others, seen)],
    uirevision: `${statistic()} ${state.choices.file}`,
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
  const units = [...new Set([curves[lead].unit, ...curves.map((one) => one.unit)])];
  const drawn = curves.flatMap((curve, i) => (units.indexOf(curve.unit) > 1 ? [] : lines(curve, wanted[i], i, i === lead, units.indexOf(curve.unit) ? "y2" : "y")));
  await draw(place(), [...drawn, ...ratios(curves[lead])], form(curves, curves[lead], units));
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
  await draw(place(), lines(first, { name: first.name, file }, 0, true, "y"), form([first], first, [first.unit]));
  place().dataset.early = first.name;
}

function listen() {
  if (listening) return;
  listening = true;
  place().on("plotly_relayout", (event) => guides.dragged(event, cache.get(`${key(front().job, front().name)}/${statistic()}`)) && paint());
}

function legend(wanted) {
  const names = new Set(wanted.map((one) => key(one.job, one.name)));
  const lead = front();
  const items = rows().map((one) => {
    const id = key(one.job, one.name);
    const index = wanted.findIndex((each) => key(each.job, each.name) === id);
    const swatch = el("span", { class: "swatch" });
    if (index >= 0) swatch.style.background = series(index);
    const own = id === key(lead.job, lead.name);
    const box = el("input", { type: "checkbox", checked: names.has(id), disabled: own, test: "over", onchange: (event) => toggle(id, event.target.checked) });
    return el("li", {}, el("label", {}, box, swatch, `${one.name} `, el("span", { class: "quiet" }, fileOf(one.file)?.name ?? "", runs(one) > 1 ? ` ${number(one)}` : "")));
  });
  fill(byId("over"), items);
  const own = rows().filter((one) => one.job === run()).map((one) => key(one.job, one.name));
  byId("over-all").disabled = own.every((id) => names.has(id));
}

const ofFile = (one) => state.jobs.filter((job) => job.verb === "analyze" && state.results[job.id] && job.files?.[0] === one.file);
const runs = (one) => ofFile(one).length;
const number = (one) => `#${ofFile(one).findIndex((job) => job.id === one.job) + 1}`;

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
  for (const one of state.jobs.filter((each) => each.verb === "analyze" && each.state === "done"))
    await result(one.id).catch((error) => tell("error", error));
}

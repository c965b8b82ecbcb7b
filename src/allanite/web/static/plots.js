// What every chart has in common: colors of the page, axes, and the settings of the drawing library.

import * as api from "./api.js";
import { el } from "./dom.js";

const SERIES = ["#2E5C94", "#C1272D", "#008F6B", "#B97700", "#AA4499", "#444B54"];
const DARK = ["#79b0ff", "#ff7b72", "#3fc9a0", "#e3b341", "#dc8fd0", "#b0b8c1"];

export const dark = () => {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
};

export const series = (index) => (dark() ? DARK : SERIES)[index % SERIES.length];

export const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export function faint(hex, share) {
  const [r, g, b] = [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
  return `rgba(${r},${g},${b},${share})`;
}

export const CONFIG = {
  displaylogo: false,
  responsive: true,
  scrollZoom: false,
  displayModeBar: false,
  edits: { shapePosition: true },
};

export function axis(title, more = {}) {
  return {
    title: { text: title, font: { size: 13 }, standoff: 8 },
    gridcolor: color("--line"),
    linecolor: color("--soft"),
    zerolinecolor: color("--line"),
    tickcolor: color("--soft"),
    showline: true,
    automargin: true,
    ticks: "outside",
    ...more,
  };
}

/** Numbers at every decade, or more of them where there are few decades. */
const steps = ([low, high] = [0, 9]) => (high - low < 1.2 ? "D1" : high - low < 2.6 ? "D2" : 1);

export const log = (title, more = {}) => axis(title, { type: "log", tickformat: "~g", dtick: steps(more.range), minor: { dtick: "D1", showgrid: false, ticks: "outside", ticklen: 3 }, ...more });

export function layout(more) {
  return {
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    font: { family: getComputedStyle(document.body).fontFamily, size: 13, color: color("--ink") },
    margin: { l: 64, r: 16, t: 16, b: 48 },
    hovermode: "closest",
    hoverlabel: { bgcolor: color("--wash"), bordercolor: color("--line"), font: { color: color("--ink") } },
    showlegend: false,
    legend: { orientation: "h", font: { size: innerWidth < 600 ? 11 : 13 }, x: 0, y: 1.01, yanchor: "bottom", traceorder: "normal", itemclick: false, itemdoubleclick: false },
    ...more,
  };
}

/** The axis of a second unit, at the right. */
export const beside = (unit, more = {}) => (unit ? { yaxis2: log(unit, { overlaying: "y", side: "right", showgrid: false, ...more }), margin: { l: 64, r: 64, t: 16, b: 48 } } : {});

/** A name as the drawing library shows it letter by letter, by its beginning if it is long: it reads tags and templates. */
export const literal = (name, most = 60) => (name.length > most ? `${name.slice(0, most)}…` : name).replace(/[&<>%]/g, (letter) => `&#${letter.charCodeAt(0)};`);

export function draw(place, traces, form, settings = CONFIG) {
  place.style.height = `${form.height}px`;
  return Plotly.react(place, traces, form, settings);
}

/** The band between two curves, as two traces. */
export function between(x, low, high, hue, share, name) {
  const common = { x, mode: "lines", line: { width: 0, color: hue }, hoverinfo: "skip", showlegend: false, name };
  return [{ ...common, y: low }, { ...common, y: high, fill: "tonexty", fillcolor: faint(hue, share) }];
}

/** A value of a curve between its points, straight on logarithmic axes. */
export function at(x, y, wanted) {
  let i = x.findIndex((one) => one >= wanted);
  if (i < 0) i = x.length - 1;
  if (i < 1) i = 1;
  const share = Math.log(wanted / x[i - 1]) / Math.log(x[i] / x[i - 1]);
  return y[i - 1] * (y[i] / y[i - 1]) ** share;
}

const rounded = (most) => (value) => Number(value.toPrecision(most)).toString();

export const digits = rounded(3);
export const written = rounded(4);

/** The figure of a result as the command line draws it; nothing where there is none. */
export async function picture(job, alt, test) {
  const made = await api.saved(job, "figure.svg", { dark: dark() ? 1 : 0 }).catch(() => null);
  if (!made) return [];
  const image = el("img", { src: URL.createObjectURL(made.blob), alt, test });
  image.addEventListener("load", () => URL.revokeObjectURL(image.src));
  return el("div", { class: "paper scroll", tabIndex: 0 }, image);
}

// A stream that is watched: what is said of it, and its curves as they grow.

import * as api from "./api.js";
import { byId, complaint, el, fill, fragment, show } from "./dom.js";
import { follow, perform } from "./jobs.js";
import { beside, between, draw, layout, literal, log, series } from "./plots.js";
import { spoken } from "./naming.js";
import { on, state, tell } from "./state.js";
import { t } from "./words.js";

const LINES = 200;
let last = null;

function heard(name, { text, channels }) {
  const log = byId("live-log");
  if (name === "words") log.append(el("li", { test: "live-line" }, spoken(text)));
  while (log.children.length > LINES) log.firstChild.remove();
  log.scrollTop = log.scrollHeight;
  if (channels?.length) paint((last = channels));
}

function paint(curves) {
  show(byId("live-plot"), true);
  const units = [...new Set(curves.map((one) => one.unit))];
  const traces = curves.flatMap((one, i) => [
    ...(one.low ? between(one.tau, one.low, one.high, series(i), 0.15, one.name) : []),
    { x: one.tau, y: one.deviation, mode: "lines+markers", marker: { size: 4 }, line: { color: series(i) }, name: literal(one.name), showlegend: true },
  ].map((line) => ({ ...line, yaxis: units.indexOf(one.unit) ? "y2" : "y" })));
  draw(byId("live-plot"), traces, layout({ height: 360, showlegend: true, xaxis: log(t("tau")), yaxis: log(units[0]), ...beside(units[1]) }));
}

const wanted = () => {
  const read = (id) => byId(id).value.trim();
  const rate = read("live-rate");
  return { ...(rate ? { rate: Number(rate) } : {}), ...(read("live-unit") ? { unit: read("live-unit") } : {}) };
};

async function watch(event) {
  event.preventDefault();
  fill(byId("live-log"));
  fill(byId("live-results"));
  await showing(perform("watch", [], wanted(), heard, { target: byId("live-source").value.trim() }));
}

async function showing(result) {
  running(true);
  try {
    const made = await result;
    fill(byId("live-results"), (made.channels ?? []).flatMap((one) => [
      fragment(el("div", { class: "fragment" }), one.html),
      el("ul", {}, one.findings.map(({ text }) => el("li", {}, spoken(text)))),
    ]));
  } catch (error) {
    fill(byId("live-results"), complaint(error, "error-live"));
  }
  running(false);
}

let watching = false;

function running(yes) {
  watching = yes;
  byId("live-start").disabled = yes || byId("live-source").value.trim() === "";
  byId("live-stop").disabled = !yes;
}

const latest = () => state.jobs.findLast((one) => one.verb === "watch");

/** A stream that was watched before the page was loaded goes on, or has its results. */
function restore() {
  const job = latest();
  if (!["waiting", "running", "done"].includes(job?.state)) return;
  byId("live-section").open ||= job.state !== "done";
  byId("live-source").value = job.target;
  showing(follow(job.id, "watch", heard));
}

function stop() {
  const job = latest();
  if (job) api.cancel(job.id).catch((error) => tell("error", error));
}

export function start() {
  byId("live-source").addEventListener("input", () => running(watching));
  running(false);
  byId("live-form").addEventListener("submit", watch);
  byId("live-stop").addEventListener("click", stop);
  on("theme", () => last && paint(last));
  restore();
}

// Results in the words of the report: its own sheets, one channel at a time.

import { byId, el, fill, fragment, show } from "./dom.js";
import { front } from "./curves.js";
import { shown } from "./jobs.js";
import { choose, on } from "./state.js";
import { t } from "./words.js";

const again = new Map();

function tabs(channels, current) {
  return channels.map((one, i) => {
    const chosen = one === current;
    return el("button", { type: "button", role: "tab", id: `tab-${i}`, "aria-selected": String(chosen), "aria-controls": "sheet", tabIndex: chosen ? 0 : -1, test: "tab", onclick: () => choose({ channel: one.name }), onkeydown: (event) => walk(event, channels, i) }, one.name);
  });
}

function walk(event, channels, i) {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (!step) return;
  event.preventDefault();
  const next = (i + step + channels.length) % channels.length;
  choose({ channel: channels[next].name });
  byId(`tab-${next}`)?.focus();
}

function assumed(result) {
  const notes = result.notes ?? result.value?.notes ?? [];
  fill(byId("assumed"), notes.length ? el("details", { open: true }, el("summary", {}, t("assumed")), el("ul", { test: "assumed" }, notes.map((note) => el("li", {}, note)))) : []);
}

export function draw() {
  const result = shown();
  show(byId("results-section"), Boolean(result));
  if (!result) return fill(byId("assumed"));
  assumed(result);
  fragment(byId("whole-result"), result.html ?? "");
  const channels = result.channels ?? [];
  const name = front()?.name;
  const current = channels.find((one) => one.name === name) ?? channels[0];
  fill(byId("tabs"), channels.length > 1 ? tabs(channels, current) : []);
  if (current) {
    byId("sheet").setAttribute("aria-labelledby", channels.length > 1 ? `tab-${channels.indexOf(current)}` : "results-title");
    fragment(byId("sheet"), again.get(current.name) ?? current.html);
  } else fill(byId("sheet"));
  return undefined;
}

export function start() {
  on("result", () => { again.clear(); draw(); });
  on("shown", () => { again.clear(); draw(); });
  on("choices", (patch) => "channel" in patch && draw());
  on("language", draw);
  on("refit", ({ channel, html }) => {
    if (html) again.set(channel, html);
    draw();
  });
}

// Results in the words of the report: its own sheets, one channel at a time.

import { button, byId, el, fill, fragment, show } from "./dom.js";
import { front } from "./curves.js";
import { shown } from "./jobs.js";
import { spoken } from "./naming.js";
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

const sheetOf = (one) => fragment(el("div"), again.get(one.name) ?? one.html);

/** The card of a channel, whose name makes it the one that is shown. */
function card(one, current) {
  const found = sheetOf(one).querySelector(".card");
  if (!found) return null;
  found.dataset.testid = "card";
  if (one === current) found.dataset.current = "yes";
  for (const value of found.querySelectorAll("dd")) fill(value, value.textContent.split(/(?<=[,，])/).flatMap((part) => [/^\s/.test(part) && " ", el("span", {}, part.trim())])); // broken after a comma first
  const pick = () => choose({ channel: one.name });
  found.addEventListener("click", pick);
  const event = one.findings?.find((each) => each.at); // what happened in the record
  if (event) found.append(el("p", { test: "card-finding" }, spoken(event.text).split(/[;；]/)[0]));
  found.querySelector("a").replaceWith(button(one.name || t("channel"), "card-name", pick, { class: "plain", "aria-current": one === current ? "true" : null }));
  return found;
}

function assumed(result) {
  const notes = [...(result.findings ?? []).map((one) => one.text), ...(result.notes ?? result.value?.notes ?? [])];
  fill(byId("assumed"), notes.length ? el("details", { open: true }, el("summary", {}, t("assumed")), el("ul", { test: "assumed" }, notes.map((note) => el("li", {}, spoken(note))))) : []);
}

export function draw() {
  const result = shown();
  show(byId("results-section"), Boolean(result));
  if (!result) {
    fill(byId("cards"));
    return fill(byId("assumed"));
  }
  assumed(result);
  fragment(byId("whole-result"), result.html ?? "");
  const channels = result.channels ?? [];
  const name = front()?.name;
  const current = channels.find((one) => one.name === name) ?? channels[0];
  fill(byId("tabs"), channels.length > 1 ? tabs(channels, current) : []);
  if (current) {
    byId("sheet").setAttribute("aria-labelledby", channels.length > 1 ? `tab-${channels.indexOf(current)}` : "results-title");
    fill(byId("sheet"), ...sheetOf(current).childNodes);
    byId("sheet").querySelector(".card")?.remove();
  } else fill(byId("sheet"));
  fill(byId("cards"), channels.map((one) => card(one, current)));
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

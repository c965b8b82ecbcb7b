// What is taken away: files for other programs, the data sheet, reports, the recipe, the command line that repeats it.

import * as api from "./api.js";
import { button, byId, complaint, copyable, el, fill, fragment, menu, show } from "./dom.js";
import { shown } from "./jobs.js";
import { on, run, state, tell } from "./state.js";
import { t } from "./words.js";

const FORMS = [
  ["report", "report", "HTML"],
  ["pdf", "report", "PDF"],
  ["json", "results", "JSON"],
  ["coefficients", "coefficients", "CSV"],
  ["csv", "points", "CSV"],
  ["recipe", "recipe", "TOML"],
  ["figure.svg", "figure", "SVG"],
  ["figure.png", "figure", "PNG"],
];

const KEPT = 60_000; // ms in which the browser takes a file over

let fresh = async () => {};

/** Have the browser save a file. */
function download({ blob, name }) {
  const link = el("a", { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), KEPT);
}

async function save(form) {
  try {
    await fresh();
    download(await api.saved(run(), form));
  } catch (error) {
    tell("error", error);
  }
}

async function give(target) {
  const place = byId("exported");
  place.ariaBusy = "true";
  try {
    await fresh();
    const channels = [...byId("export-channels").querySelectorAll("input:checked")].map((box) => box.value);
    const ticked = (id) => byId(id).checked || undefined;
    const other = byId("export-model").value.trim();
    const order = { channels, target, lang: state.choices.lang, unexplained: ticked("unexplained"), from_curve: ticked("from-curve"), cover: ticked("uncovered") && false, models: other ? [other] : [] };
    const { text, filename, html } = await api.exported(run(), order);
    const whole = copyable(text, "export-text", t("copy"));
    const file = () => download({ blob: new Blob([text], { type: "text/plain" }), name: filename });
    fill(place, el("h3", {}, filename ?? target), html ? [fragment(el("div", { class: "fragment", test: "export-fields" }), html), el("details", {}, el("summary", { test: "export-fold" }, filename), whole)] : whole, button(`${t("save")}: ${filename}`, "export-save", file));
  } catch (error) {
    fill(place, complaint(error, "error-target"));
  }
  place.ariaBusy = "false";
}

function draw() {
  const result = shown();
  show(byId("output-section"), Boolean(result));
  fill(byId("exported"));
  if (!result) return;
  const names = (result.channels ?? []).map((one) => one.name);
  fill(byId("export-channels"), names.map((name) => el("label", {}, el("input", { type: "checkbox", value: name, checked: true, test: "export-channel" }), name)));
  enable();
  fill(byId("repeat"), result.command ? [el("h3", {}, t("command")), copyable(result.command, "command", t("copy"))] : [],
    result.toml ? el("details", {}, el("summary", { test: "recipe-fold" }, t("recipe")), copyable(result.toml, "toml", t("copy"))) : []);
}

function menus() {
  fill(byId("target"), menu(state.tables.exports, byId("target").value || undefined));
  fill(byId("saves"), FORMS.map(([form, word, kind]) => button(`${t(word)} (${kind})`, `save-${form}`, () => save(form))));
}

export const exportNow = () => give(byId("target").value);

/** Without a channel there is nothing to export. */
function enable() {
  const none = !byId("export-channels").querySelector("input:checked");
  for (const id of ["export", "datasheet"]) byId(id).disabled = none;
}

/** `renew` makes the analysis agree with the choices before anything is taken away. */
export function start(renew) {
  fresh = renew;
  byId("export").addEventListener("click", exportNow);
  byId("export-channels").addEventListener("change", enable);
  byId("datasheet").addEventListener("click", () => give("datasheet"));
  on("result", draw);
  on("shown", draw);
  on("language", () => { menus(); draw(); });
  menus();
}

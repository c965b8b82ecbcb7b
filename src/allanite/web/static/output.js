// What is taken away: files for other programs, the data sheet, reports, the recipe, the command line that repeats it.

import * as api from "./api.js";
import { button, byId, copyable, el, fill, menu, show } from "./dom.js";
import { shown } from "./jobs.js";
import { on, run, state, tell } from "./state.js";
import { t } from "./words.js";

const FORMS = [
  ["report", "HTML"],
  ["pdf", "PDF"],
  ["json", "JSON"],
  ["csv", "CSV"],
  ["recipe", "TOML"],
  ["figure.svg", "SVG"],
  ["figure.png", "PNG"],
];

let fresh = async () => {};

function download(address, name) {
  const link = el("a", { href: address, download: name ?? "" });
  document.body.append(link);
  link.click();
  link.remove();
}

async function save(form) {
  try {
    await fresh();
    download(api.saved(run(), form));
  } catch (error) {
    tell("error", error);
  }
}

async function give(target) {
  const place = byId("exported");
  try {
    await fresh();
    const channels = [...byId("export-channels").querySelectorAll("input:checked")].map((box) => box.value);
    const { text, filename } = await api.exported(run(), { channels, target });
    const file = () => download(URL.createObjectURL(new Blob([text], { type: "text/plain" })), filename);
    fill(place, el("h3", {}, filename ?? target), copyable(text, "export-text", t("copy")), button(`${t("save")}: ${filename}`, "export-save", file));
  } catch (error) {
    fill(place, el("p", { class: "error", role: "alert", test: "error-target" }, error.message));
  }
}

function draw() {
  const result = shown();
  show(byId("output-section"), Boolean(result));
  fill(byId("exported"));
  if (!result) return;
  const names = (result.channels ?? []).map((one) => one.name);
  fill(byId("export-channels"), names.map((name) => el("label", {}, el("input", { type: "checkbox", value: name, checked: true, test: "export-channel" }), name)));
  fill(byId("repeat"), result.command ? [el("h3", {}, t("command")), copyable(result.command, "command", t("copy"))] : [],
    result.toml ? el("details", {}, el("summary", { test: "recipe-fold" }, t("recipe")), copyable(result.toml, "toml", t("copy"))) : []);
}

function menus() {
  fill(byId("target"), menu(state.tables.exports, byId("target").value || undefined));
  fill(byId("saves"), FORMS.map(([form, title]) => button(title, `save-${form}`, () => save(form))));
}

export const exportNow = () => give(byId("target").value);

/** `renew` makes the analysis agree with the choices before anything is taken away. */
export function start(renew) {
  fresh = renew;
  byId("export").addEventListener("click", exportNow);
  byId("datasheet").addEventListener("click", () => give("datasheet"));
  on("result", draw);
  on("shown", draw);
  on("language", () => { menus(); draw(); });
  menus();
}

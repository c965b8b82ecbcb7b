// What is taken away: files for other programs, the data sheet, reports, the recipe, the command line that repeats it.

import * as api from "./api.js";
import { button, byId, complaint, copier, copyable, el, fill, fragment, menu, show } from "./dom.js";
import { shown } from "./jobs.js";
import { label } from "./naming.js";
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

const option = ({ name }) => byId(`export-${name}`);

/** The choices of an export, those that are given. */
const how = () => Object.fromEntries(state.tables.how.map((row) => [row.name, byId(`export-${row.name}-typed`)?.value.trim() || (READ[row.control]?.(option(row)) ?? option(row).value.trim())]).filter(([, value]) => value !== "" && value !== false));

const READ = {
  flag: (node) => node.checked,
  number: (node) => (node.value === "" ? "" : Number(node.value)),
  list: (node) => (node.value.trim() === "" ? "" : [node.value.trim()]),
};

/** A choice of an export as a control. */
function control({ name, control: kind, values, hint }) {
  const shared = { id: `export-${name}`, test: `export-${name}` };
  const typed = (key, more = {}) => el("input", { ...shared, id: `${shared.id}${key}`, test: `${shared.test}${key}`, type: "text", placeholder: hint, spellcheck: "false", ...more });
  if (values) return el("span", {}, el("label", {}, label(name), " ", el("select", shared, menu(values, "", t("auto")))), hint ? [" ", typed("-typed", { "aria-label": `${label(name)}: ${t("taus")}` })] : []);
  if (kind !== "flag" && kind !== "number") return el("label", { class: "wide" }, label(name), " ", typed(""));
  const node = el("input", { ...shared, type: kind === "flag" ? "checkbox" : "number", step: kind === "number" ? "any" : null });
  return el("label", {}, kind === "flag" ? [node, label(name)] : [label(name), " ", node]);
}

async function give(target) {
  const place = byId("exported");
  place.ariaBusy = "true";
  try {
    await fresh();
    const channels = [...byId("export-channels").querySelectorAll("input:checked")].map((box) => box.value);
    const { text, filename, html } = await api.exported(run(), { channels, target, lang: state.choices.lang, ...how() });
    const file = () => download({ blob: new Blob([text], { type: "text/plain" }), name: filename });
    const take = [copier(text, "export-text-copy", t("copy")), button(`${t("save")}: ${filename}`, "export-save", file)];
    const whole = el("pre", { tabIndex: 0, test: "export-text" }, text);
    fill(place, el("h3", {}, filename ?? target), html ? fragment(el("div", { class: "fragment", test: "export-fields" }), html) : [], el("div", { class: "row" }, take),
      html ? el("details", {}, el("summary", { test: "export-fold" }, filename), whole) : whole);
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
  const [seldom, often] = [true, false].map((rare) => state.tables.how.filter((row) => row.rare === rare).map(control));
  fill(byId("export-options"), often, el("details", {}, el("summary", { test: "export-more" }, t("more")), el("span", { class: "group" }, seldom)));
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

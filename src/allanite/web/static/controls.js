// The choices as controls: each with its help, what was assumed, and its own place for an error.

import { button, byId, el, fill, menu, show } from "./dom.js";
import { shown } from "./jobs.js";
import { alter, on, recipe, state, tell } from "./state.js";
import { t } from "./words.js";

// key of the recipe, word of its label, group, kind of control
const CONTROLS = [
  ["rate", "rate", "reading", "number"],
  ["unit", "unit", "reading", "text"],
  ["kind", "kind", "reading", "kinds"],
  ["channels", "channels", "reading", "list"],
  ["scale", "scale", "reading-more", "text"],
  ["time", "timecolumn", "reading-more", "text"],
  ["dtype", "dtype", "reading-more", "text"],
  ["columns", "columns", "reading-more", "number"],
  ["offset", "offset", "reading-more", "number"],
  ["sincos", "sincos", "reading-more", "list"],
  ["start", "from", "analysis", "number"],
  ["until", "until", "analysis", "number"],
  ["exclude", "exclude", "analysis", "text"],
  ["outliers", "outliers", "analysis", "outliers"],
  ["method", "method", "analysis-more", "methods"],
  ["terms", "terms", "analysis-more", "text"],
  ["band", "band", "analysis-more", "band"],
  ["level", "level", "analysis-more", "number"],
  ["taus", "taus", "analysis-more", "text"],
  ["average", "average", "analysis-more", "number"],
  ["device", "device", "analysis-more", "devices"],
  ["to", "to", "analysis-more", "list"],
];

const parts = (text) => text.split(",").map((part) => part.trim()).filter(Boolean);

const READ = {
  number: (text) => (text === "" ? "" : Number(text)),
  list: (text) => (text === "" ? "" : parts(text)),
  band: (text) => (/^[^a-z]+,[^a-z]+$/i.test(text) ? parts(text).map(Number) : text),
};

const input = (key) => byId(`option-${key}`);

const helpOf = (key) => state.tables.options?.analyze?.[key];

function change(key, kind, node) {
  node.shown = node.value;
  const value = (READ[kind] ?? ((text) => text))(node.value.trim());
  clear(key);
  alter({ [key]: value });
  tell("altered", key);
}

function control([key, word, , kind]) {
  const rows = state.tables[kind]?.filter((row) => row.name !== "");
  const shared = { id: `option-${key}`, test: `option-${key}`, "aria-describedby": `error-${key} help-${key}` };
  const node = rows
    ? el("select", shared, menu(rows, "", t("auto")))
    : el("input", { ...shared, type: kind === "number" ? "number" : "text", step: kind === "number" ? "any" : undefined, list: key === "unit" ? "units" : undefined, autocomplete: "off", spellcheck: "false" });
  node.addEventListener("change", () => change(key, kind, node));
  const help = helpOf(key);
  return el("div", { class: "control" },
    el("label", { for: `option-${key}` }, t(word)),
    node,
    help && el("details", { class: "help" }, el("summary", { test: `help-${key}`, "aria-label": `${t("help")}: ${t(word)}` }, "?"), el("p", { id: `help-${key}` }, help)),
    el("p", { class: "error", id: `error-${key}`, role: "alert", test: `error-${key}`, hidden: true }));
}

export function build() {
  for (const group of ["reading", "reading-more", "analysis", "analysis-more"])
    fill(byId(`controls-${group}`), CONTROLS.filter((row) => row[2] === group).map(control));
  const names = Object.values(state.tables.units ?? {}).flat();
  fill(byId("units"), names.map((name) => el("option", { value: name.name ?? name })));
  refresh();
}

/** Show what is chosen, and as a hint what was taken from the file; what is being typed stays. */
export function refresh() {
  const chosen = recipe();
  const assumed = facts(shown());
  for (const [key, , , kind] of CONTROLS) {
    const value = chosen[key];
    const node = input(key);
    const typing = node === document.activeElement && node.value !== (node.shown ?? "");
    if (!typing) node.value = node.shown = Array.isArray(value) ? value.join(",") : (value ?? "");
    if (node.tagName === "SELECT") node.options[0].textContent = assumed[key] ? `${t("auto")}: ${assumed[key]}` : t("auto");
    else node.placeholder = assumed[key] ?? (kind === "number" ? "" : t("auto"));
  }
}

/** What was assumed, read from the result. */
function facts(result) {
  const channels = result?.value?.channels ?? [];
  const of = (key) => [...new Set(channels.map((one) => one[key]).filter((value) => value !== null && value !== undefined))].join(", ");
  return { rate: of("rate"), unit: of("unit"), kind: of("kind"), channels: of("name") };
}

export function clear(key) {
  show(fill(byId(`error-${key}`)), false);
  input(key).removeAttribute("aria-invalid");
}

export function clearErrors() {
  for (const [key] of CONTROLS) clear(key);
  show(byId("problem"), false);
}

/** The words of an error beside the control that cures it, else above everything. */
export function refuse(error) {
  const key = error.option === "from" ? "start" : error.option;
  if (!CONTROLS.some((row) => row[0] === key)) {
    fill(byId("problem"), el("span", { test: "problem-text" }, error.message), button("×", "problem-close", () => show(byId("problem"), false), { class: "small", "aria-label": t("close") }));
    show(byId("problem"), true);
    return;
  }
  const place = byId(`error-${key}`);
  fill(place, error.message);
  show(place, true);
  if (error.message.includes("--unit")) {
    byId("error-unit").append(unitButtons());
    show(byId("error-unit"), true);
  }
  input(key).setAttribute("aria-invalid", "true");
  for (const fold of [byId("side-fold"), input(key).closest("details")]) if (fold) fold.open = true;
  input(key).scrollIntoView({ block: "center" });
  input(key).focus();
}

/** The usual units, one click each. */
function unitButtons() {
  const names = Object.values(state.tables.units ?? {}).flatMap((list) => list.slice(0, 4)).map((row) => row.name ?? row);
  return el("span", { class: "choices", role: "group", "aria-label": t("unit") },
    names.map((name) => button(name, `unit-${name}`, () => { input("unit").value = name; change("unit", "text", input("unit")); }, { class: "small" })));
}

on("choices", (patch) => (patch.recipes || patch.file) && state.tables && byId("option-unit") && refresh());

// The choices as controls: each with its help, what was assumed, and its own place for an error.

import * as columns from "./columns.js";
import { button, byId, el, fill, menu, show } from "./dom.js";
import { shown } from "./jobs.js";
import { label, spoken } from "./naming.js";
import { alter, fileOf, on, recipe, run, state, tell } from "./state.js";
import { legible } from "./trace.js";
import { t } from "./words.js";

const AXES = 3; // columns that one unit may be for
const UNREADABLE = 3; // exit code of data that cannot be read

// choices that are always in sight; the others are among more options
const FRONT = ["rate", "unit", "kind", "channels", "start", "until", "exclude", "outliers"];

// choices with a menu
const MENUS = { kind: "kinds", outliers: "outliers", method: "methods", device: "devices" };

// the choices of a recipe as the server lists them; the statistic has its place above the curve
const controls = () => (state.tables?.choices ?? []).filter((row) => row.name !== "statistic");

const placeOf = (row) => `${row.group === "reading" ? "reading" : "analysis"}${FRONT.includes(row.name) ? "" : "-more"}`;

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

function control({ name: key, control: kind }) {
  const rows = state.tables[MENUS[key]]?.filter((row) => row.name !== "");
  const shared = { id: `option-${key}`, test: `option-${key}`, "aria-describedby": `error-${key} help-${key}` };
  const node = rows
    ? el("select", shared, menu(rows, "", t("auto")))
    : el("input", { ...shared, type: kind === "number" ? "number" : "text", step: kind === "number" ? "any" : undefined, list: key === "unit" ? "units" : undefined, autocomplete: "off", spellcheck: "false" });
  node.addEventListener("change", () => change(key, kind, node));
  const help = spoken(helpOf(key) ?? "");
  return el("div", { class: "control" },
    el("label", { for: `option-${key}` }, label(key)),
    node,
    help && el("details", { class: "help" }, el("summary", { test: `help-${key}`, "aria-label": `${t("help")}: ${label(key)}` }, "?"), el("p", { id: `help-${key}` }, help)),
    el("p", { class: "error", id: `error-${key}`, role: "alert", test: `error-${key}`, hidden: true }));
}

export function build() {
  for (const group of ["reading", "reading-more", "analysis", "analysis-more"])
    fill(byId(`controls-${group}`), controls().filter((row) => placeOf(row) === group).map(control));
  const names = Object.values(state.tables.units ?? {}).flat();
  fill(byId("units"), names.map((name) => el("option", { value: name.name ?? name })));
  refresh();
}

/** Show what is chosen, and as a hint what was taken from the file; what is being typed stays. */
export function refresh() {
  const chosen = recipe();
  const assumed = facts(shown());
  for (const { name: key, control: kind } of controls()) {
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
  for (const { name } of controls()) clear(name);
  show(byId("problem"), false);
}

/** The words of an error beside the control that cures it, else in place of the results of its file, or above everything. */
export function refuse(error) {
  const key = error.option;
  if (!controls().some((row) => row.name === key)) {
    if (fileOf(error.file) && !run()) {
      tell("failed", { file: error.file, words: spoken(error.message), unreadable: error.exit === UNREADABLE && !legible(error.file) });
      return;
    }
    fill(byId("problem"), el("span", { test: "problem-text" }, spoken(error.message)), button("×", "problem-close", () => show(byId("problem"), false), { class: "small", "aria-label": t("close") }));
    show(byId("problem"), true);
    return;
  }
  const place = byId(`error-${key}`);
  fill(place, spoken(error.message.split("\n")[0])); // the rest is the table of columns
  show(place, true);
  const rows = /--scale/.test(error.cure) ? null : error.columns;
  if (rows) columns.ask(error);
  const sensors = sensorUnits(error.cure);
  const several = !sensors && rows?.filter((row) => row.use === "signal").length > AXES;
  if (!several && (key === "unit" || error.message.includes("--unit"))) {
    byId("error-unit").append(sensors ?? unitButtons());
    show(byId("error-unit"), true);
  }
  input(key).setAttribute("aria-invalid", "true");
  for (const fold of [byId("side-fold"), input(key).closest("details")]) if (fold) fold.open = true;
  if (several) {
    columns.focus();
    return;
  }
  input(key).scrollIntoView({ block: "center" });
  input(key).focus();
}

/** Units of the sensors that the server asks for, "--unit gyro=UNIT,accel=g": a menu each, and one button for all. */
function sensorUnits(cure) {
  const asked = /--unit '?([^' ]+=[^' ]+)/.exec(cure)?.[1].split(",").map((pair) => pair.split("=")) ?? [];
  if (asked.length < 2 || asked.some(([sensor]) => !state.tables.units[sensor])) return null;
  const chosen = () => menus.map((node, i) => `${asked[i][0]}=${node.value}`).join(",");
  const apply = button(t("apply"), "unit-apply", () => { input("unit").value = chosen(); change("unit", "text", input("unit")); }, { class: "small" });
  const able = () => { apply.disabled = menus.some((node) => !node.value); };
  const menus = asked.map(([sensor, unit]) => el("select", { test: `unit-of-${sensor}`, onchange: able },
    menu([...new Set([...(unit === "UNIT" ? [] : [unit]), ...state.tables.units[sensor]])], unit, t("unit"))));
  able();
  return el("span", { class: "choices" }, menus.map((node, i) => el("label", {}, t(asked[i][0]), " ", node)), apply);
}

/** The usual units, one click each. */
function unitButtons() {
  const names = Object.values(state.tables.units ?? {}).flatMap((list) => list.slice(0, 4)).map((row) => row.name ?? row);
  return el("span", { class: "choices", role: "group", "aria-label": t("unit") },
    names.map((name) => button(name, `unit-${name}`, () => { input("unit").value = name; change("unit", "text", input("unit")); }, { class: "small" })));
}

on("choices", (patch) => (patch.recipes || patch.file) && state.tables && byId("option-unit") && refresh());

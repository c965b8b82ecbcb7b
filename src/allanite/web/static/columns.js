// The columns of a file that does not say what they are: what their numbers show, and what each is read as.

import { button, byId, el, fill, show } from "./dom.js";
import { alter, fileOf, on, state, tell } from "./state.js";
import { t } from "./words.js";

const CLOCKS = ["s", "ms", "us", "ns"];
const NUMBERS = ["mean", "std", "step"];
const SHOWN = [...NUMBERS, "looks"];
const OUT = "out"; // the value of a menu; otherwise what a column is and its unit, "signal|deg/s"

let asked = null; // the error that asks for them, of the file that is shown
let chosen = {}; // by keys of columns, what was changed

/** What a column is read as: as it was chosen or proposed; empty if that is still open. */
const use = (row) => chosen[row.key] ?? (!row.use ? OUT : row.unit && `${row.use}|${row.unit}`);

function picker(row) {
  const groups = [["clock", "time", CLOCKS], ["gyro", "signal", state.tables.units.gyro], ["accel", "signal", state.tables.units.accel]];
  const value = use(row);
  const option = (name, text) => el("option", { value: name, selected: name === value }, text);
  const known = groups.flatMap(([, what, units]) => units.map((unit) => `${what}|${unit}`));
  return el("select", { test: `use-of-${row.key}`, "aria-label": `${t("use")}: ${row.label}`, onchange: (event) => pick(row, event.target.value) },
    option("", t("pick")), option(OUT, t("leaveout")),
    value && value !== OUT && !known.includes(value) && option(value, value.split("|")[1]),
    groups.map(([word, what, units]) => el("optgroup", { label: t(word) }, units.map((unit) => option(`${what}|${unit}`, unit)))));
}

/** A unit is also that of the other axes of the sensor, as long as theirs is open. */
function pick(row, value) {
  const alike = row.sensor && value ? asked.columns.filter((one) => one.sensor === row.sensor && !use(one)) : [];
  for (const one of [...alike, row]) chosen[one.key] = value;
  draw();
  byId("columns-table").querySelector(`[data-testid="use-of-${row.key}"]`).focus();
}

/** The options that say it. */
function options() {
  const uses = asked.columns.map((row) => [row.key, ...use(row).split("|"), row.use]);
  const signals = uses.filter(([, what]) => what === "signal");
  const clock = uses.find(([, what]) => what === "time");
  return {
    time: clock ? `${clock[0]}[${clock[2]}]` : uses.some((one) => one.at(-1) === "time") ? "none" : "",
    unit: signals.map(([key, , unit]) => `${key}=${unit}`).join(","),
    channels: signals.map(([key]) => key),
    ...(asked.kind ? { kind: asked.kind } : {}),
  };
}

function apply() {
  alter(options());
  tell("altered", "unit");
}

const kind = (key) => (NUMBERS.includes(key) ? "number" : null);

const ready = () => {
  const uses = asked.columns.map((row) => use(row).split("|")[0]);
  return !uses.includes("") && uses.includes("signal") && uses.filter((what) => what === "time").length < 2;
};

function draw() {
  show(byId("columns-section"), Boolean(asked));
  if (!asked) return fill(byId("columns-table"));
  const head = el("tr", {}, ["column", ...SHOWN, "use"].map((word) => el("th", { scope: "col", class: kind(word) }, t(word))));
  const line = (row) => el("tr", { test: "column" }, el("th", { scope: "row", class: "name" }, row.label),
    SHOWN.map((key) => el("td", { class: kind(key), "data-label": t(key) }, row[key])), el("td", { "data-label": t("use") }, picker(row)));
  return fill(byId("columns-table"), el("div", { class: "scroll", tabIndex: 0, role: "group", "aria-labelledby": "columns-title" }, el("table", { class: "stack terms" }, el("thead", {}, head), el("tbody", {}, asked.columns.map(line)))),
    button(t("apply"), "columns-apply", apply, { disabled: !ready() }));
}

/** Ask what the columns are that an error names; `error.cure` may also propose what a sample is. */
export function ask(error) {
  if (asked?.file !== error.file || String(asked.keys) !== String(error.columns.map((row) => row.key))) chosen = {};
  asked = { file: error.file, columns: error.columns, keys: error.columns.map((row) => row.key), kind: /--kind (\w+)/.exec(error.cure)?.[1] };
  draw();
}

/** Bring the first menu that is open into sight. */
export function focus() {
  const menus = [...byId("columns-table").querySelectorAll("select")];
  byId("columns-section").scrollIntoView({ block: "start" });
  (menus.find((node) => !node.value) ?? menus[0])?.focus({ preventScroll: true });
}

export function start() {
  const end = () => { asked = null; draw(); };
  for (const name of ["shown", "result"]) on(name, end);
  on("choices", () => asked && !fileOf(asked.file) && end());
  on("language", draw);
}

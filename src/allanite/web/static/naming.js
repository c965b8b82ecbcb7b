// What choices are called on this page: by their controls, where the command line names options.

import { state } from "./state.js";
import { t } from "./words.js";

// choices with a label of another name
const LABELS = { start: "from", time: "timecolumn", mask: "masked" };

export const label = (key) => t(LABELS[key] ?? key).replaceAll("_", " ");

/** What a control is called, without its unit. */
export const plain = (key) => label(key).replace(/[,(].*$/, "").trim();

// an option of the command line, and what may be its value
const OPTION = /(--[a-z][a-z-]*)(?:([= ])('[^']*'|[^\s;:()'"]*[^\s;:()'",.]))?/g;

/** Sentences of the command line as this page says them: “Unit” where they have --unit UNIT, “Unit” = g for --unit g. */
export function spoken(words) {
  const rows = [...(state.tables?.choices ?? []), ...(state.tables?.how ?? [])];
  return words.replace(/(--[a-z-]+ (?=\S*[\d=/^])[^\s-]\S*) (?=--[a-z])/g, "$1, ").replace(OPTION, (whole, option, sign, value = "", at = 0, all = words) => {
    const row = rows.find((one) => one.options.includes(option));
    if (!row) return whole;
    const name = t("named").replace("%", plain(row.name));
    if (/^[A-Z]+$/.test(value) || !value) return name;
    const given = sign === "=" || /[\d'/=^]/.test(value) || /^($|[;,.)])/.test(all.slice(at + whole.length));
    return given ? `${name} = ${value.replaceAll("'", "")}` : `${name}${sign}${value}`;
  });
}

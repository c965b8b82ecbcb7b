// What choices are called on this page: by their controls, where the command line names options.

import { state } from "./state.js";
import { t } from "./words.js";

// choices with a label of another name
const LABELS = { start: "from", time: "timecolumn", mask: "masked" };

export const label = (key) => t(LABELS[key] ?? key).replaceAll("_", " ");

/** What a control is called, without its unit. */
export const plain = (key) => label(key).replace(/[,(].*$/, "").trim();

/** Words of the command line as this page says them. */
export function spoken(words) {
  const row = (option) => state.tables?.choices.find((one) => one.options.includes(option));
  return words.replace(/--[a-z][a-z-]*/g, (option) => (row(option) ? t("named").replace("%", plain(row(option).name)) : option));
}

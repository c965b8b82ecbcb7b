// Light or dark, and the language.

import * as api from "./api.js";
import { byId, el, fill } from "./dom.js";
import { dark } from "./plots.js";
import { choose, state, tell } from "./state.js";
import { speak, t } from "./words.js";

const NEXT = { "": "dark", dark: "light", light: "" };

export function paint() {
  const root = document.documentElement;
  if (state.choices.theme) root.dataset.theme = state.choices.theme;
  else delete root.dataset.theme;
  for (const row of state.tables.terms) if (row.color) root.style.setProperty(`--${row.color.toLowerCase().slice(1)}`, dark() ? row.dark : row.color);
  byId("theme").dataset.theme = state.choices.theme ?? "";
  tell("theme");
}

export function turn() {
  choose({ theme: NEXT[state.choices.theme ?? ""] });
  paint();
}

export async function setLanguage(lang) {
  choose({ lang }, true);
  state.tables = await api.tables(lang);
  speak(lang);
  languages();
  tell("language", lang);
}

export function languages() {
  fill(byId("language"), state.tables.languages.map((row) => el("option", { value: row.code, selected: row.code === state.choices.lang }, row.name)));
}

export function start() {
  byId("theme").addEventListener("click", turn);
  byId("language").addEventListener("change", (event) => setLanguage(event.target.value).catch((error) => tell("error", error)));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
  speak(state.choices.lang);
  languages();
  paint();
  byId("theme").title = t("theme");
}

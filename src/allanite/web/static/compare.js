// Two records side by side: did the noise change?

import { byId, complaint, el, fill, fragment, menu, show } from "./dom.js";
import { perform } from "./jobs.js";
import { picture } from "./plots.js";
import { on, recipe, state } from "./state.js";
import { t } from "./words.js";

const others = () => state.files.filter((file) => file.id !== state.choices.file);

function draw() {
  show(byId("compare-section"), Boolean(state.choices.file) && others().length > 0);
  fill(byId("compare-with"), menu(others().map((file) => ({ name: file.id, title: file.name })), byId("compare-with").value));
  for (const option of byId("compare-with").options) option.textContent = state.files.find((file) => file.id === option.value)?.name ?? "";
  fill(byId("compared"));
}

export async function compare() {
  const place = byId("compared");
  try {
    const made = await perform("compare", [state.choices.file, byId("compare-with").value], recipe());
    const job = made.id ?? made.job ?? state.jobs.findLast((one) => one.verb === "compare").id;
    const image = await picture(job, t("compare"), "picture-compare");
    fill(place, made.html ? fragment(el("div", { class: "fragment" }), made.html) : [],
      image,
      (made.channels ?? []).map((one) => fragment(el("div", { class: "fragment", test: "compared" }), one.html)));
  } catch (error) {
    fill(place, complaint(error, "error-compare"));
  }
}

export function start() {
  byId("compare").addEventListener("click", compare);
  for (const name of ["shown", "language", "file"]) on(name, draw);
  draw();
}

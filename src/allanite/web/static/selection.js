// A piece of the record: cut out, used alone, or seen as a spectrum or a surface.

import { byId, el, fill, fragment, show } from "./dom.js";
import { perform, shown } from "./jobs.js";
import { alter, cuts, depth, on, recipe, redo, state, tell, undo } from "./state.js";
import { picture } from "./plots.js";
import { channel, known, outlying } from "./trace.js";
import { t } from "./words.js";

const written = (value) => Number(value.toFixed(3)).toString();

function select(range) {
  state.selection = range;
  byId("select-from").value = range ? written(range[0]) : "";
  byId("select-until").value = range ? written(range[1]) : "";
  enable();
  tell("selection");
}

/** The piece whose ends are written in the two fields. */
function piece() {
  const [a, b] = [byId("select-from"), byId("select-until")].map((node) => (node.value === "" ? null : Number(node.value)));
  return a !== null && b !== null && a < b ? [a, b] : null;
}

function changed(patch) {
  alter(patch);
  select(null);
  tell("altered", Object.keys(patch)[0]);
}

/** Pieces in order, those that touch made one. */
function joined(pieces) {
  const ordered = pieces.sort((a, b) => a[0] - b[0]);
  return ordered.reduce((all, [a, b]) => {
    const last = all.at(-1);
    if (last && a <= last[1]) last[1] = Math.max(last[1], b);
    else all.push([a, b]);
    return all;
  }, []);
}

export function cut() {
  const one = piece();
  if (!one) return;
  changed({ exclude: joined([...cuts(), one]).map((ends) => ends.map(written).join("..")).join(",") });
}

export function only() {
  const one = piece();
  if (one) changed({ start: Number(written(one[0])), until: Number(written(one[1])) });
}

export function mask() {
  changed({ outliers: recipe().outliers === "mark" ? "" : "mark" });
}

export function back(step) {
  if (step()) tell("altered", "history");
}

async function look(verb) {
  const [start, until] = piece() ?? [recipe().start, recipe().until];
  const name = channel();
  const wanted = { ...recipe(), ...(name ? { channels: [name] } : {}) };
  for (const [key, value] of Object.entries({ start, until })) if (value !== undefined) wanted[key] = value;
  try {
    const made = await perform(verb, [state.choices.file], wanted);
    await draw(verb, made);
  } catch (error) {
    tell("error", error);
  }
}

async function draw(verb, made) {
  const job = made.id ?? made.job ?? state.jobs.findLast((one) => one.verb === verb).id;
  const title = `${t(verb)}: ${channel() ?? ""}`;
  const image = await picture(job, title, `picture-${verb}`);
  const words = el("div", { class: "fragment" });
  for (const one of made.channels ?? []) words.append(fragment(el("div"), one.html));
  fill(byId("looked"), el("h3", {}, title), image, el("details", {}, el("summary", {}, t("results")), words));
  show(byId("looked"), true);
}

function enable() {
  const one = piece();
  for (const id of ["cut", "only"]) byId(id).disabled = !one || !known();
  for (const id of ["spectrum", "dynamic"]) byId(id).disabled = !shown();
  byId("mask").disabled = recipe().outliers !== "mark" && !outlying();
  byId("mask").setAttribute("aria-pressed", String(recipe().outliers === "mark"));
  const { undo: behind, redo: ahead } = depth();
  byId("undo").disabled = behind === 0;
  byId("redo").disabled = ahead === 0;
}

export function start() {
  for (const id of ["select-from", "select-until"])
    byId(id).addEventListener("change", () => { state.selection = piece(); enable(); tell("selection"); });
  const acts = { cut, only, mask, undo: () => back(undo), redo: () => back(redo), spectrum: () => look("spectrum"), dynamic: () => look("dynamic") };
  for (const [id, act] of Object.entries(acts)) byId(id).addEventListener("click", act);
  on("selected", select);
  on("shown", () => { select(null); show(byId("looked"), false); });
  for (const name of ["history", "choices", "traced", "result"]) on(name, enable);
  enable();
}

// Slope guides: the curve of one noise term, moved until it lies on the data; its place is the coefficient.

import { button, byId, el, fill, menu } from "./dom.js";
import { at, color, dark, digits } from "./plots.js";
import { choose, state } from "./state.js";
import { t } from "./words.js";

const own = () => state.choices.guides ?? [];
const shapeOf = (curve, symbol) => curve?.guides?.find((one) => one.symbol === symbol);
const hue = (symbol) => {
  const row = state.tables.terms.find((one) => one.symbol === symbol);
  return (dark() ? row?.dark : row?.color) ?? color("--soft");
};

/** The guides of the unit of this curve, each with the curve of its term. */
const drawn = (curve) => own().map((guide, index) => ({ ...guide, index, shape: shapeOf(curve, guide.symbol) })).filter(({ shape, unit }) => shape && (unit ?? shape.unit) === shape.unit);

export function shapes(curve, yref = "y") {
  return drawn(curve).map(({ symbol, value, shape }) => {
    const [first, last] = [shape.deviation.findIndex((one) => one > 0), shape.deviation.findLastIndex((one) => one > 0)];
    return { type: "line", yref, name: symbol, x0: shape.tau[first], x1: shape.tau[last], y0: value * shape.deviation[first], y1: value * shape.deviation[last], line: { color: hue(symbol), width: 2, dash: "dot" } };
  });
}

/** The lines of the guides, for their labels. */
export const lines = (curve) => drawn(curve).map(({ symbol, value, shape }) => ({ x: shape.tau, y: shape.deviation.map((one) => value * one), text: `${symbol} = ${digits(value)} ${shape.unit}`, color: hue(symbol) }));

/** A guide was dragged: where it lies now, read by the curve of its term. */
export function dragged(event, curve) {
  const moved = drawn(curve).flatMap((guide, number) => {
    const value = (name) => event[`shapes[${number}].${name}`];
    if (value("y0") === undefined && value("y1") === undefined && value("x0") === undefined) return [];
    const line = { ...shapes(curve)[number] };
    for (const name of ["x0", "x1", "y0", "y1"]) line[name] = Number(value(name) ?? line[name]);
    const x = Math.sqrt(line.x0 * line.x1);
    return [[guide.index, Math.sqrt(line.y0 * line.y1) / at(guide.shape.tau, guide.shape.deviation, x)]];
  });
  if (!moved.length) return false;
  set(moved);
  return true;
}

function set(moved) {
  const guides = own().map((one) => ({ ...one }));
  for (const [index, value] of moved) if (Number.isFinite(value) && value > 0) guides[index].value = value;
  choose({ guides }, true);
}

/** A new guide starts at the coefficient of the model, or at the least one whose curve touches the data. */
function add(curve) {
  const symbol = byId("guide-term").value;
  const shape = shapeOf(curve, symbol);
  if (!shape) return;
  const fitted = curve.terms?.find((one) => one.symbol === symbol && one.unit === shape.unit)?.value;
  const value = fitted ?? Math.min(...curve.deviation.map((one, i) => one / at(shape.tau, shape.deviation, curve.tau[i])).filter(Number.isFinite));
  if (Number.isFinite(value) && value > 0) choose({ guides: [...own(), { symbol, value, unit: shape.unit }] });
}

export function list(curve) {
  const place = byId("guides");
  const rows = drawn(curve).map((guide) => {
    const field = el("input", { type: "number", step: "any", value: String(digits(guide.value)), "aria-label": `${guide.symbol}, ${guide.shape.unit}`, test: "guide-value", onchange: (event) => { set([[guide.index, Number(event.target.value)]]); choose({ guides: own() }); } });
    const remove = button("×", "guide-remove", () => choose({ guides: own().filter((_, i) => i !== guide.index) }), { class: "small", "aria-label": `${t("remove")} ${guide.symbol}` });
    return el("li", {}, el("strong", {}, guide.symbol), field, el("span", { test: "guide-unit" }, guide.shape.unit), remove);
  });
  fill(place, rows);
  const before = byId("guide-term").value;
  fill(byId("guide-term"), menu((curve.guides ?? []).map((one) => ({ name: one.symbol, title: one.title })), before || undefined));
  byId("guide-add").disabled = byId("guide-term").disabled = !curve.guides?.length;
  byId("guide-add").onclick = () => add(curve);
}

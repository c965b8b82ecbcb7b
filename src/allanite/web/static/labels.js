// Labels at the lines of a chart: each where its line is far from everything else. Lengths are shares of the chart.

const LETTER = 7.6; // pixels of a letter, and of a line of text
const LINE = 18;
const STEP = 4;
const EDGE = 0.02;
const OWN = 1.8; // its own line may be nearer than the others
const SHIFTS = [-1.15, 0, 1.15].flatMap((across) => [-1.5, 1.5].map((up) => [across, up])); // from the line, in half sizes

/** Points of a line on logarithmic axes, those that are seen. */
const points = ({ x, y }, [left, right], [low, high]) => x.flatMap((one, i) => {
  if (!(y[i] > 0)) return [];
  const at = [(Math.log10(one) - left) / (right - left), (Math.log10(y[i]) - low) / (high - low)];
  return at.every((share) => share > -0.1 && share < 1.1) ? [at] : [];
});

/** Distance of a label to the nearest point, in half sizes of it: below 1 it is touched. */
const free = ([u, v], width, height, others) => others.reduce((least, [a, b]) => Math.min(least, Math.max(Math.abs(a - u) / width, Math.abs(b - v) / height)), 3);

/** Where to write the text of each line: `named` are lines with text and color, `others` stay visible, `size` is in pixels. */
export function labels(named, others, { x, y, size, yref = "y" }) {
  const seen = named.map((line) => points(line, x, y));
  const known = others.flatMap((line) => points(line, x, y));
  const taken = [];
  return named.flatMap(({ text, color }, i) => {
    const [width, height] = [(LETTER * text.length) / size[0] / 2, LINE / size[1] / 2];
    const inside = ([u, v]) => u > width + EDGE && u < 1 - width - EDGE && v > height + EDGE && v < 1 - height - EDGE;
    const beside = SHIFTS.map(([across, up]) => [across * width, up * height]);
    const places = seen[i].filter((_, k) => k % STEP === 0).flatMap(([u, v]) => beside.map(([du, dv]) => [u + du, v + dv])).filter(inside);
    const around = [...known, ...taken, ...seen.filter((_, k) => k !== i).flat()];
    const worth = places.map((place) => Math.min(free(place, width, height, around), OWN * free(place, width, height, seen[i])));
    if (!places.length) return [];
    const [u, v] = places[worth.indexOf(Math.max(...worth))];
    for (const du of [-1, -0.5, 0, 0.5, 1]) taken.push([u + du * width, v]);
    return [{ xref: "x", yref, x: x[0] + u * (x[1] - x[0]), y: y[0] + v * (y[1] - y[0]), text, showarrow: false, font: { color, size: 13 } }];
  });
}

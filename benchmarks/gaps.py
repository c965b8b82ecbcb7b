"""Records of a rate with lost readings: limits of coefficients and of curves against the truth.

Readings are lost one by one at random, or in bursts that start at random. Each record is identified by "auto"; the
limits of its curves are averaged over the models that it leaves open. `patterns` looks only for limits that are no
numbers, of every statistic that takes gaps. Every cell has seeds of its own: the numbers of the sensor, of the loss and
of the record.
"""

from table import Row, begin, covered, markdown, spread

import itertools
import math
import os
from collections.abc import Iterator

import numpy as np

import allanite as al
from allanite.core.errors import AllaniteError
from allanite.statistics import STATISTICS

SENSORS = {name: al.sensor(name) for name in ("MEMS", "FOG", "RLG")}
"""At 100 Hz."""

LOSSES = {
    "none": (0.0, 1),
    **{f"{share} %{', bursts of ' + str(length) if length > 1 else ''}": (share / 100, length)
       for length, shares in ((1, (1, 5, 10, 30)), (20, (1, 5, 10, 30)), (500, (5, 10, 30))) for share in shares},
}  # fmt: skip
"""Share of the readings that are lost, and how many at a time."""

RATE, SIZE = 100.0, 2**15

SHARES = (0.1, 0.2, 0.4)
CURVES = ("oadev", "ohdev")
LEVEL = 0.95


def lost(size: int, share: float, length: int, rng: np.random.Generator) -> np.ndarray:
    """Which readings are lost, shape (size,): bursts that start at random, until the share is reached."""
    if length == 1:
        return rng.random(size) < share
    gone = np.zeros(size, dtype=bool)
    while gone.mean() < share:
        start = int(rng.integers(0, size - length))
        gone[start : start + length] = True
    return gone


def record_of(sensor: str, loss: str, i: int, size: int = SIZE) -> al.Record:
    """One record of a cell."""
    rng = np.random.default_rng((list(SENSORS).index(sensor), list(LOSSES).index(loss), i))
    whole = al.simulate(SENSORS[sensor], size, RATE, rng=rng)
    values = np.array(whole.values, dtype=np.float64)
    values[lost(size, *LOSSES[loss], rng)] = np.nan
    return al.Record(values, RATE, whole.unit, kind="rate")


def coefficients_of(job: tuple[str, str, int]) -> dict[str, tuple[float, ...]]:
    """Of each true term: estimate over truth (0 if not claimed), whether its limits hold it; empty if all is refused.

    A term of which the fit says that it is not observable has nan for both. "p" has the goodness of fit.
    """
    sensor, loss, i = job
    try:
        fit = al.identify(record_of(sensor, loss, i))
    except AllaniteError:
        return {}
    found: dict[str, tuple[float, ...]] = {"p": (fit.goodness.p,)}
    for t in SENSORS[sensor]:
        e = fit[t.symbol]
        low, high = (math.nan, math.nan) if e.status == "not observable" else e.interval(LEVEL)
        found[t.symbol] = (e.value or 0.0) / t.value, math.nan if math.isnan(low) else float(low <= t.value <= high)
    return found


def coefficient_rows(sensor: str, loss: str, answers: list[dict[str, tuple[float, ...]]]) -> Iterator[Row]:
    """A row for each true term of a cell."""
    known = [answer for answer in answers if answer]
    explained = 100 * np.mean([answer["p"][0] >= 0.01 for answer in known]) if known else math.nan
    for t in SENSORS[sensor]:
        pairs = np.array([answer[t.symbol] for answer in known if not math.isnan(answer[t.symbol][1])])
        head = (sensor, loss, t.symbol, f"{100 * (1 - len(pairs) / len(answers)):.0f}")
        if not len(pairs):
            yield (*head, "", "", "", "")
            continue
        claimed = pairs[pairs[:, 0] > 0, 0]
        rms = f"{100 * math.sqrt(np.mean((claimed - 1) ** 2)):.1f}" if claimed.size else ""
        shares = f"{100 * claimed.size / len(pairs):.0f}", f"{100 * pairs[:, 1].mean():.1f}"
        yield (*head, *shares, rms, f"{explained:.0f}")


def curves_of(job: tuple[str, str, int]) -> dict[tuple[str, float], tuple[int, float, float]]:
    """Of each statistic and share of the record: place of the truth (-1 below the limits), their ratio, error."""
    sensor, loss, i = job
    record = record_of(sensor, loss, i)
    try:
        fit = al.identify(record)
    except AllaniteError:
        return {}
    found = {}
    for name in CURVES:
        for share in SHARES:
            m = int(share * SIZE)
            if m > STATISTICS[name].largest(SIZE):
                continue
            try:
                curve = al.deviation(record, name, m=[m], noise=fit)
            except AllaniteError:
                continue
            (low,), (high,) = curve.interval(LEVEL)
            truth = math.sqrt(al.expected(SENSORS[sensor], name, curve.tau, rate=RATE)[0])
            place = -1 if truth < low else int(truth > high)
            found[name, share] = place, high / low, float(curve.deviation[0]) / truth
    return found


def curve_rows(
    sensor: str, loss: str, answers: list[dict[tuple[str, float], tuple[int, float, float]]]
) -> Iterator[Row]:
    """A row for each statistic and averaging time of a cell."""
    for name, share in itertools.product(CURVES, SHARES):
        if share * SIZE > STATISTICS[name].largest(SIZE):
            continue
        points = np.array([answer[name, share] for answer in answers if (name, share) in answer])
        cells = ("", "", "")
        if len(points):
            rms = f"{math.sqrt(np.mean(points[:, 2] ** 2)):.3f}"
            cells = covered(points[:, 0]), f"{np.median(points[:, 1]):.3g}", rms
        yield (sensor, loss, name, f"{share:g}", f"{100 * len(points) / len(answers):.0f}", *cells)


PATTERN = al.N(1, "deg/sqrt(h)") + al.B(3, "deg/h")
GAPS = [name for name, row in STATISTICS.items() if row.gaps and row.order > 1]
"""Statistics that take gaps and have limits."""


def pattern_of(job: tuple[int]) -> list[str]:
    """Statistics whose limits of a record with random losses are not all numbers with 0 < low < high."""
    (i,) = job
    rng = np.random.default_rng((1000, i))
    size = int(rng.integers(200, 4097))
    record = al.simulate(PATTERN, size, 1.0, rng=rng)
    values = np.array(record.values, dtype=np.float64)
    length = int(rng.choice([1, 1, 3, 20, 100]))
    values[lost(size, float(rng.uniform(0.002, 0.5)), min(length, size // 4), rng)] = np.nan
    record = al.Record(values, 1.0, record.unit, kind="rate")
    wrong = []
    for name in {"oadev", GAPS[i % len(GAPS)]}:
        try:
            curve = al.deviation(record, name, noise=PATTERN)
        except AllaniteError:  # no window is left
            continue
        low, high = curve.interval()
        if not (np.isfinite(low) & np.isfinite(high) & (low > 0) & (low < high)).all():
            wrong.append(name)
    return wrong


TABLES = {
    "coefficients": (
        "Coefficients with gaps", coefficients_of, coefficient_rows,
        "refused: % not observable, or the record refused; claimed, 95: % of the others, and whose limits hold the "
        "truth; rms: of those claimed, %; explained: % of records with p of 1 % or more",
        ("sensor", "lost", "term", "refused", "claimed", "95", "rms, %", "explained"),
    ),
    "curves": (
        "Curves with gaps", curves_of, curve_rows,
        "there: % of records with the point; 95: % of them whose limits hold the truth (+ truth above, - below)"
        "; ratio: median upper over lower limit; rms: root mean square of value over truth",
        ("sensor", "lost", "statistic", "tau / T", "there", "95", "ratio", "rms"),
    ),
}  # fmt: skip
"""Title, what is made of a record, the rows of a cell, a note and the headings."""


def main() -> None:
    """Make a table."""
    run = begin(__doc__, what=(*TABLES, "patterns"), records=400, sensors=list(SENSORS), losses=list(LOSSES),
                processes=os.cpu_count() or 1)  # fmt: skip
    asked = run.asked
    if asked.what == "patterns":
        ((_, wrong),) = spread(pattern_of, [()], asked.records, asked.processes)
        body = [f"{sum(map(bool, wrong))} of {asked.records} patterns with limits that are no numbers"]
        run.publish("Limits in any pattern of gaps", ["seeds: 1000 and the number of the record"], body)
        return
    title, work, rows_of, note, headings = TABLES[asked.what]
    rows: list[Row] = []
    for cell, answers in spread(work, itertools.product(asked.sensors, asked.losses), asked.records, asked.processes):
        rows += rows_of(*cell, answers)
        print(*rows[-1], flush=True)
    notes = [
        "seeds: numbers of the sensor, of the loss and of the record",
        f"{asked.records} records a cell of {SIZE} samples at {RATE:g} Hz; `identify` with its defaults",
        note,
    ]
    run.publish(title, notes, markdown(headings, rows))


if __name__ == "__main__":
    main()

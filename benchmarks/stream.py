"""Streams: samples per second beside allantools.realtime and the batch, and coefficients beside the bound.

Speed: processor time of the thread, best of seven, of one run: what else runs on the machine slows all of it, and the
ratios less than the rest. Coefficients: simulated records pushed in 16 chunks, and some of the same records as a whole;
root mean square errors over the Cramer-Rao bound of the terms of the model.
"""

from table import begin, least, section

import time
from functools import partial

import allantools.realtime
import numpy as np

import allanite as al
from allanite.planning.datasheets import sensor
from allanite.stream.accumulator import streamable

SAMPLES = 4_000_000
PEER = 3000
SENSORS = (("mems", 100.0, 2**20, "NBK"), ("fog", 1.0, 2**18, "QNBKR"))


def speed() -> list[list[str]]:
    """Rows: what, million samples per second, times allantools.realtime."""
    values = np.random.default_rng(1).normal(size=SAMPLES)
    factors = [m for m in _factors() if m <= PEER // 2]
    taken = partial(least, clock=time.thread_time)

    def peer() -> None:
        found = allantools.realtime.oadev_realtime(afs=np.array(factors))
        for value in values[:PEER].tolist():
            found.add_frequency(value)

    slow = PEER / taken(peer, 2)
    rows = [[f"allantools.realtime, oadev, {len(factors)} averaging times", f"{slow / 1e6:.4f}", "1"]]
    record = al.Record(values, 1.0, "deg/h")
    batch = taken(lambda: al.deviation(record, m=[m for m in _factors() if m <= SAMPLES // 2], noise=None), 2)
    rows.append(["al.deviation, the same averaging times, every window", *_row(SAMPLES / batch, slow)])
    for chunk in (SAMPLES, 10_000, 100):
        for statistic in streamable() if chunk == SAMPLES else ("oadev",):
            stream = al.Accumulator(1.0, "deg/h", statistic=statistic)
            parts = np.split(values[: SAMPLES if chunk > 100 else 800_000], range(chunk, SAMPLES, chunk)[:7999])

            def push(stream: al.Accumulator = stream, parts: list[np.ndarray] = parts) -> None:
                for part in parts:
                    stream.push(part)

            push()
            pace = sum(part.size for part in parts) / taken(push, 5 if chunk > 100 else 2)
            rows.append([f"Accumulator, {statistic}, chunks of {chunk}", *_row(pace, slow)])
    return rows


def _row(pace: float, slow: float) -> list[str]:
    return [f"{pace / 1e6:.1f}", f"{pace / slow:.0f}"]


def _factors() -> list[int]:
    return [*range(1, 16), *(q << k for k in range(1, 24) for q in range(8, 16))]


def coefficients(records: int, whole: int) -> list[list[str]]:
    """Rows: sensor, samples, term, bound, and the errors of stream and batch over it."""
    rows = []
    for name, rate, n, terms in SENSORS:
        model, errors = sensor(name), []
        for seed in range(1, records + 1):
            record = al.simulate(model, n, rate, rng=np.random.default_rng(seed))
            stream = al.Accumulator(rate, record.unit, record.kind)
            for part in np.array_split(record.values, 16):
                stream.push(part)
            fits = [stream.fit(terms, band="all")]
            if seed <= whole:
                fits.append(al.identify(record, terms=terms, band="all", lines=False))
            errors.append([[abs((fit[s].value or 0.0) / model[s].value) - 1 for s in terms] for fit in fits])
        bound = al.bound(model, n, rate)
        tables = [[own[0] for own in errors], [own[0] for own in errors[:whole]], [own[1] for own in errors[:whole]]]
        rms = [np.sqrt(np.mean(np.square(own), axis=0)) for own in tables]
        for i, symbol in enumerate(terms):
            ratio = [f"{own[i] / bound[symbol]:.2f}" for own in rms]
            rows.append([name, str(n), symbol, f"{100 * bound[symbol]:.2g}", *ratio])
    return rows


def main() -> None:
    run = begin(__doc__, records=200, whole=40)
    fast = speed()
    size = al.Accumulator(1.0, "deg/h").nbytes
    notes = [
        f"seeds: 1..{run.asked.records}; errors over bound are known to {100 / np.sqrt(2 * run.asked.records):.0f} %",
        "the machine was shared: read the ratios of one run, not the paces",
    ]
    body = section("Speed", ["what", "million samples/s", "times allantools.realtime"], fast,
                   f"White noise; an Accumulator of oadev holds {size} bytes.")  # fmt: skip
    headings = ["sensor", "samples", "term", "bound %", "stream / bound", "some: stream", "some: whole"]
    body += section("Coefficients", headings, coefficients(run.asked.records, run.asked.whole))
    run.publish("Streams", notes, body)


if __name__ == "__main__":
    main()

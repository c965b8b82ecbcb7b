"""What each component of the search gains in records that do not have it, and how often it is claimed there.

    python benchmarks/prices.py --lines FILE.jsonl [--short 40] [--usual 60] [--long 20] [--write PATH]

So many records of 2^13, 2^16 and 2^18 samples of each null are made by `independent`: clean, behind a filter, and
beside a resonance, which the states to compare with then have. The gain of a row of the table of components is how
much lower 2 L' is with one such part more than without, sizes and shapes refined and all powers free; of several states
of the component that is there, the best of either side counts. FILE has a line for each record; a record that it has is
not made again, which is right for the gains as long as they do not change, and wrong for the claims of other prices.
The seed is the CRC-32 of null and size, and the number of the record.
"""

from table import begin, section

import json
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch
from zlib import crc32

import numpy as np

import allanite as al
import independent as sim
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.search import moves, search
from allanite.identification.search.components import CLAIMED, FACTORS, ODDS, cost_of
from allanite.identification.search.fitting import Fitted, fitted
from allanite.identification.search.frame import Frame, frame_of
from allanite.identification.search.refining import Local, Move, pruned, refined, resized
from allanite.identification.search.state import State
from prices_table import claims_rows, gains_rows, nulls_rows, weights_rows

SYMBOLS = ("Q", "N", "B", "K", "R")
RATE, SETTLING = 100.0, 8192
"""Rate, Hz, and samples in which filters and resonances forget their start."""

Truth = dict[str, Any]
Made = tuple[sim.Values, Truth]
Maker = Callable[[int, float, sim.Rng], Made]

ARCSEC = 1 / 3600
MEMS: Truth = {"N": 0.005, "B": 0.002, "K": 3e-4}
FOG: Truth = {"Q": 0.4 * ARCSEC, "N": 3 * ARCSEC, "B": ARCSEC, "K": 0.09 * ARCSEC, "R": 0.002 * ARCSEC}
RLG: Truth = {"Q": 0.5 * ARCSEC, "N": 0.18 * ARCSEC, "B": 0.05 * ARCSEC}
CLEAN: dict[str, Truth] = {
    "mems": MEMS, "fog": FOG, "rlg": RLG, "N": {"N": 0.005}, "N+K": {"N": 0.005, "K": 1e-3},
    "strong N+K": {"N": 0.005, "K": 1e-2}, "Q+N": {"Q": 2e-4, "N": 0.002},
}  # fmt: skip


def plain(noise: Truth) -> Maker:
    """A sensor, deg and s."""
    return lambda n, rate, rng: (sim.sensor(n, rate, rng, **noise), dict(noise))


def behind(noise: Truth, low_pass: sim.Filter) -> Maker:
    """A sensor behind a digital filter at the rate of the record."""

    def make(n: int, rate: float, rng: sim.Rng) -> Made:
        y = sim.behind(sim.sensor(n + SETTLING, rate, rng, **noise), [low_pass])[SETTLING:]
        return y, dict(noise, N=noise["N"] * math.sqrt(sim.folded([low_pass])))

    return make


ROWS: dict[str, tuple[Move, str]] = {
    "noise": (moves.markov, ""), "filter": (moves.filters, ""), "floor": (moves.floors, ""),
    "resonance": (moves.resonances, ""), "step": (moves.steps, ""), "warm-up": (moves.warm_ups, ""),
    "exponent": (moves.exponents, ""), **{f"factor: {kind}": (search.factors, kind) for kind in FACTORS},
}  # fmt: skip
"""Rows of the table of components by what is listed, how they are added, and the kind of a factor."""

STATES = 3  # states of the component that is there, beside which others are tried, at most

TUNED = {"filter": 1, "resonance": 1, "warm-up": 3}
"""Rows whose alternatives are no shapes that are refined, and how often these are exchanged."""

EXPENSIVE = 1e3  # price of the kinds of a factor that are not tried


@dataclass(frozen=True)
class Null:
    """How a record is made, and the row of the component that it has beside noise."""

    make: Maker
    beside: str = ""


def resonant(n: int, rate: float, rng: sim.Rng) -> Made:
    """MEMS beside a resonance."""
    y, known = plain(MEMS)(n, rate, rng)
    shaking = sim.resonance(n + SETTLING, 0.17, 30.0, 200.0, rng, squared=False)[SETTLING:]
    return y + MEMS["N"] * math.sqrt(rate) * shaking, known


NULLS: dict[str, Null] = {
    **{name: Null(plain(noise)) for name, noise in CLEAN.items()},
    "fog behind rc fs/12": Null(behind(FOG, sim.rc(1 / 12)), "filter"),
    "mems beside a resonance": Null(resonant, "resonance"),
}
BASE: dict[str, tuple[Move, ...]] = {
    "filter": (moves.less, moves.exchanged, moves.filters),
    "resonance": (moves.less, moves.exchanged, moves.resonances),
}
"""Moves that lead to the states of the component that is there."""


@contextmanager
def trying_all(kind: str) -> Iterator[None]:
    """Candidates are fitted however little they promise, beside the start only; factors of one kind, for nothing."""
    prices = {k: ODDS if k == kind else EXPENSIVE for k in FACTORS} if kind else FACTORS
    with (
        patch.object(Local, "able", lambda self, gain, cost: True),
        patch.object(moves, "LEAST_EVIDENCE", -math.inf),
        patch.object(search, "EXPANSIONS", 0),
        patch.dict(FACTORS, prices),
    ):
        yield


def value_of(f: Fitted) -> float:
    """2 L' of a state with all powers free."""
    return refined(resized(f, np.ones(f.theta.size, dtype=bool)), 4).value


def bases_of(frame: Frame, beside: str) -> list[Fitted]:
    """The best states without the components whose prices are asked for."""
    if not beside:
        return [pruned(refined(fitted(frame, State())))]
    every = search.search(frame, moves=BASE[beside], unexplained=False).every.values()
    return sorted((f for f in every if len(f.state.of(beside)) == 1), key=lambda f: f.score)[:STATES]


def grown(frame: Frame, base: Fitted, name: str, move: Move) -> list[Fitted]:
    """The states with one part more of a row beside a state; also with other time constants, numerators, filters."""
    tries = search.search(frame, (base.state,), moves=(move,), unexplained=False).every.values()
    count = len(base.state.parts) + 1
    more = [f for f in tries if len(f.state.parts) == count and len(f.state.of(name)) > len(base.state.of(name))]
    for _ in range(TUNED.get(name, 0) if more else 0):
        best = min(more, key=lambda f: f.score)
        change = moves.warm_ups if name == "warm-up" else moves.exchanged
        more += [pruned(refined(fitted(frame, s))) for s in change(Local(best))]
    return more


def gain_of(frame: Frame, bases: list[Fitted], row: str) -> tuple[float, float]:
    """What a row gains: in 2 L' with all powers free, and in the score with the best of them, its own cost aside."""
    name, (move, kind) = row.partition(":")[0], ROWS[row]
    value, score = min(map(value_of, bases)), min(f.score for f in bases)
    with trying_all(kind):
        more = [f for base in bases for f in grown(frame, base, name, move)]
        more = [f for f in more if not kind or any(p.label == kind for p in f.state.of(name))]
        scores = [f.score - cost_of(f.state.of(name)[0], frame) for f in more]
    return value - min(map(value_of, more), default=value), score - min(scores, default=score)


def gains_of(frame: Frame, beside: str) -> dict[str, tuple[float, float]]:
    """What each row gains that may stand beside what is there."""
    bases = bases_of(frame, beside)
    rows = [row for row in ROWS if not row == beside == "filter" and (row != "floor" or beside == "filter")]
    return {row: gain_of(frame, bases, row) for row in rows} if bases else {}


def claims_of(record: al.Record, beside: str, truth: dict[str, Any]) -> dict[str, Any]:
    """Weights of the components in the default identification, and what it claims that is not there."""
    fit = al.identify(record)
    names = [c.name for c in fit.components]
    weights = {c.name: c.weight for c in fit.components}
    return {
        "weights": weights,
        "false": [k for k, w in weights.items() if w >= CLAIMED and names.count(k) > (k == beside)],
        "terms": [e.symbol for e in fit if e.claimed and e.symbol in SYMBOLS and e.symbol not in truth],
        "lines": len(fit.lines),
    }


def line_of(name: str, n: int, index: int) -> dict[str, Any]:
    """The line of one record."""
    null, rng = NULLS[name], np.random.default_rng((crc32(f"prices/{name}/{n}".encode()), index))
    y, truth = null.make(n, RATE, rng)
    record = al.Record(y, rate=RATE, unit="deg/s", kind="rate")
    since = time.process_time()
    claims = claims_of(record, null.beside, truth)
    seen = spectrum(record, detrend=True)
    gains = gains_of(frame_of(seen, SYMBOLS, seen.read(None, ())), null.beside)
    return {"null": name, "n": n, "index": index, "gains": gains, "cpu": time.process_time() - since} | claims


def lines_of(path: Path) -> Iterator[dict[str, Any]]:
    """The lines of a file; one that was cut off is left out."""
    for text in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        try:
            yield json.loads(text)
        except json.JSONDecodeError:
            continue


def run(sizes: dict[int, int], path: Path) -> list[dict[str, Any]]:
    """The lines of what is asked for; a file gets what it lacks: the first of each null and size, then the second."""
    done = {(line["null"], line["n"], line["index"]) for line in lines_of(path)}
    with path.open("a", encoding="utf-8") as out:
        for index in range(max(sizes.values())):
            for name in NULLS:
                for n, records in sizes.items():
                    if index < records and (name, n, index) not in done:
                        out.write(json.dumps(line_of(name, n, index)) + "\n")
                        out.flush()
    return [line for line in lines_of(path) if line["index"] < sizes.get(line["n"], 0)]


def main() -> None:
    """Print the tables."""
    job = begin(__doc__ or "", lines="", short=40, usual=60, long=20)
    asked = job.asked
    lines = run({2**13: asked.short, 2**16: asked.usual, 2**18: asked.long}, Path(asked.lines))
    body = section("Gains", *gains_rows(lines))
    body += section("Gains by null", *nulls_rows(lines), "97 % quantile of the gain.")
    body += section("Claims", *claims_rows(lines), "% of records.")
    body += section("Weights", *weights_rows(lines))
    spent = f"{sum(line['cpu'] for line in lines) / 60:.0f} min of processor time for {len(lines)} records"
    job.publish("Prices of components", (*NOTES, spent), body)


NOTES = (
    "seeds: the CRC-32 of `prices/NULL/n`, and the number of the record, from 0",
    "gain: how much lower 2 L' is with one such component more, all powers free; score: the same with the best powers, "
    "their costs counted and that of the component not; above: share of records in which it is above the price; "
    "places: effective ones, from the tenth of the records that gain most, and from 3 %",
    "false finding: a component is claimed, or a sinusoid, that is not there; false term: Q, N, B, K or R",
)

if __name__ == "__main__":
    main()

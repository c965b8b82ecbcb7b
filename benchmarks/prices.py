"""What each component of the search gains in records that do not have it, and how often it is claimed there.

So many records of 2^13, 2^16 and 2^18 samples of each null are made by `judge`: clean, behind a filter, and beside a
resonance, which the states to compare with then have. The gain of a row of the table of components is how much lower
2 L' is with one such part more than without, sizes and shapes refined and all powers free; of several states of the
component that is there, the best of either side counts. The seed is the CRC-32 of "prices/NULL/n", and the number of
the record. A price is calibrated where the shares of records above it, and of those that claim the component, are
known to a third of a percent: the default numbers of records are those that this takes.
"""

from table import Row, begin, section, spread

import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch
from zlib import crc32

import numpy as np
from scipy.special import chdtrc

import allanite as al
import judge
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.search import moves, search
from allanite.identification.search.components import CLAIMED, COMPONENTS, FACTORS, ODDS, cost_of
from allanite.identification.search.fitting import Fitted, fitted
from allanite.identification.search.frame import Frame, frame_of
from allanite.identification.search.refining import Local, Move, pruned, refined, resized
from allanite.identification.search.state import State

SYMBOLS = tuple("QNBKR")
RATE, SETTLING = 100.0, 8192
"""Rate, Hz, and samples in which filters and resonances forget their start."""

Truth = dict[str, Any]
Line = dict[str, Any]
Maker = Callable[[int, judge.Rng], judge.Values]

TAILS = (0.1, 0.03)  # shares of the records, those that gain most, from which the number of places follows
STATES = 3  # states of the component that is there, beside which others are tried, at most
EXPENSIVE = 1e3  # price of the kinds of a factor that are not tried

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
    return lambda n, rng: judge.sensor(n, RATE, rng, **noise)


def filtered(n: int, rng: judge.Rng) -> judge.Values:
    """FOG behind a first-order low-pass of a twelfth of the rate, whose gain at 0 Hz is 1."""
    return judge.behind(judge.sensor(n + SETTLING, RATE, rng, **FOG), judge.rc(1 / 12))[SETTLING:]


def resonant(n: int, rng: judge.Rng) -> judge.Values:
    """MEMS beside a resonance."""
    shaking = judge.resonance(n + SETTLING, 0.17, 30.0, 200.0, rng)[SETTLING:]
    return judge.sensor(n, RATE, rng, **MEMS) + MEMS["N"] * math.sqrt(RATE) * shaking


ROWS: dict[str, tuple[Move, str]] = {
    "noise": (moves.markov, ""), "filter": (moves.filters, ""), "floor": (moves.floors, ""),
    "resonance": (moves.resonances, ""), "step": (moves.steps, ""), "warm-up": (moves.warm_ups, ""),
    "wave": (moves.waves, ""),
    "exponent": (moves.exponents, ""), **{f"factor: {kind}": (search.factors, kind) for kind in FACTORS},
}  # fmt: skip
"""Rows of the table of components by what is listed, how they are added, and the kind of a factor."""

TUNED = {"filter": 1, "resonance": 1, "warm-up": 3}
"""Rows whose alternatives are no shapes that are refined, and how often these are exchanged."""


@dataclass(frozen=True)
class Null:
    """How a record is made, of which terms, and the row of the component that it has beside noise."""

    make: Maker
    truth: Truth
    beside: str = ""


NULLS: dict[str, Null] = {
    **{name: Null(plain(noise), noise) for name, noise in CLEAN.items()},
    "fog behind rc fs/12": Null(filtered, FOG, "filter"),
    "mems beside a resonance": Null(resonant, MEMS, "resonance"),
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
        patch.object(search, "LEAST_EVIDENCE", -math.inf),
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
    """What the default identification claims that is not there."""
    fit = al.identify(record)
    names = [c.name for c in fit.components]
    weights = {c.name: c.weight for c in fit.components}
    return {
        "false": [k for k, w in weights.items() if w >= CLAIMED and names.count(k) > (k == beside)],
        "terms": [e.symbol for e in fit if e.claimed and e.symbol in SYMBOLS and e.symbol not in truth],
        "lines": len(fit.lines),
    }


def line_of(job: tuple[str, int, int]) -> Line:
    """What one record gains and claims."""
    name, n, number = job
    null, rng = NULLS[name], np.random.default_rng((crc32(f"prices/{name}/{n}".encode()), number))
    record = al.Record(null.make(n, rng), rate=RATE, unit="deg/s", kind="rate")
    since = time.process_time()
    claims = claims_of(record, null.beside, null.truth)
    seen = spectrum(record, detrend=True)
    gains = gains_of(frame_of(seen, SYMBOLS, seen.read(None, ())), null.beside)
    return {"null": name, "n": n, "gains": gains, "cpu": time.process_time() - since} | claims


def gains_in(lines: Iterable[Line], row: str, which: int) -> np.ndarray:
    """Gains of a row in the records in which it may be added."""
    return np.array([line["gains"][row][which] for line in lines if row in line["gains"]])


def places_of(row: str, gain: np.ndarray, share: float) -> float:
    """Independent places of which the best gains as much in a share of records; 0 where one place gains more."""
    component = COMPONENTS[row.partition(":")[0]]
    at = float(np.quantile(gain, 1 - share))
    single = float(chdtrc(1, max(at, 0.0))) * (1.0 if component.signed else 0.5)
    return math.log1p(-share) / math.log1p(-single) if single < 1 else 0.0


def percent(hits: Sequence[bool] | np.ndarray) -> str:
    """A share with its standard error, that of one hit where there is none."""
    n, k = len(hits), int(np.sum(hits))
    p = max(k, 1) / n
    return f"{100 * k / n:.1f} ± {100 * math.sqrt(p * (1 - p) / n):.1f}"


def gains_rows(lines: Sequence[Line]) -> tuple[Row, list[Row]]:
    """Quantiles of what each row gains, its price, and the places that follow."""
    heads = (
        "row", "n", "records", "50 %", "90 %", "97 %", "99 %", "largest", "score: 97 %", "score: largest", "price",
        "above %", "score above %", *(f"places, {100 * share:.0f} %" for share in TAILS), "places now",
    )  # fmt: skip
    rows = []
    for row in dict.fromkeys(row for line in lines for row in line["gains"]):
        for n in dict.fromkeys(line["n"] for line in lines):
            some = [line for line in lines if line["n"] == n]
            kind, (gain, score) = row.partition(": ")[2], (gains_in(some, row, which) for which in (0, 1))
            price = FACTORS[kind] if kind else COMPONENTS[row].price(n)
            levels = [*np.quantile(gain, (0.5, 0.9, 0.97, 0.99)), gain.max(), np.quantile(score, 0.97), score.max()]
            now = "" if kind else f"{COMPONENTS[row].places(n):.3g}"
            rows.append((
                row, str(n), str(gain.size), *(f"{x:.1f}" for x in (*levels, price)), percent(gain > price),
                percent(score > price), *(f"{places_of(row, gain, share):.2g}" for share in TAILS), now,
            ))  # fmt: skip
    return heads, rows


def claims_rows(lines: Sequence[Line]) -> tuple[Row, list[Row]]:
    """How often each component is claimed in each null."""
    names = [name for name in COMPONENTS if name not in ("term", "sinusoid")]
    rows = []
    for n in dict.fromkeys(line["n"] for line in lines):
        every = [line for line in lines if line["n"] == n]
        for null in [*dict.fromkeys(line["null"] for line in every), "all"]:
            some = [line for line in every if null in (line["null"], "all")]
            each = [percent([name in line["false"] for line in some]) for name in names]
            finding = [bool(line["false"]) or line["lines"] > 0 for line in some]
            term = [bool(line["terms"]) for line in some]
            either = [a or b for a, b in zip(finding, term, strict=True)]
            waves = percent([line["lines"] > 0 for line in some])
            rows.append((null, str(n), str(len(some)), *each, waves, *map(percent, (finding, term, either))))
    return ("null", "n", "records", *names, "sinusoid", "any false finding", "any false term", "either"), rows


NOTES = (
    'seeds: the CRC-32 of "prices/NULL/n", and the number of the record from 0',
    "gain: how much lower 2 L' is with one such component more, all powers free; score: the same with the best powers, "
    "their costs counted and that of the component not; above: share of records in which it is above the price; "
    "places: effective ones, from the tenth of the records that gain most, and from 3 %",
    "false finding: a component is claimed, or a sinusoid, that is not there; false term: Q, N, B, K or R",
)


def main() -> None:
    """Print the tables."""
    job = begin(__doc__ or "", short=80, usual=100, long=60, processes=2)
    asked, lines = job.asked, []
    for n, records in ((2**13, asked.short), (2**16, asked.usual), (2**18, asked.long)):
        for cell, some in spread(line_of, ((name, n) for name in NULLS), records, asked.processes):
            lines += some
            print(*cell, file=sys.stderr, flush=True)
    body = section("Gains", *gains_rows(lines))
    body += section("Claims", *claims_rows(lines), "% of records.")
    spent = f"{sum(line['cpu'] for line in lines) / 60:.0f} min of processor time for {len(lines)} records"
    job.publish("Prices of components", (*NOTES, spent), body)


if __name__ == "__main__":
    main()

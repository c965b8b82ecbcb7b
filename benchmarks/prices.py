"""What each component of the search gains in records that do not have it.

So many records of 2^13, 2^16 and 2^18 samples of each null are made by `judge`: clean, behind a filter, and beside a
resonance, which the states to compare with then have. The gain of a row of the table of components is how much lower
2 L' is with one such part more than without, sizes and shapes refined and all powers free; of several states of the
component that is there, the best of either side counts. A price is calibrated where the share of records above it is
known to a third of a percent: the default numbers of records are those that this takes.
"""

from table import SEEDS, Row, begin, section, seeded, shared, spread

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import product
from unittest.mock import patch

import numpy as np
from scipy.special import chdtrc

import allanite as al
import judge
from allanite.identification.likelihood.spectrum import spectrum
from allanite.identification.search import moves, search
from allanite.identification.search.components import COMPONENTS, FACTORS, ODDS
from allanite.identification.search.fitting import Fitted, fitted
from allanite.identification.search.frame import Frame, frame_of
from allanite.identification.search.refining import Local, Move, pruned, refined, resized
from allanite.identification.search.state import State

SYMBOLS = tuple("QNBKR")
RATE, SETTLING = 100.0, 8192
"""Rate, Hz, and samples in which filters and resonances forget their start."""

Terms = dict[str, float]
Maker = Callable[[int, judge.Rng], judge.Values]
Line = tuple[int, dict[str, float]]
"""Samples of a record, and what each row gains in it."""

TAILS = (0.1, 0.03)  # shares of the records, those that gain most, from which the number of places follows
STATES = 3  # states of the component that is there, beside which others are tried, at most
EXPENSIVE = 1e3  # price of the kinds of a factor that are not tried

ARCSEC = 1 / 3600
MEMS: Terms = {"N": 0.005, "B": 0.002, "K": 3e-4}
FOG: Terms = {"Q": 0.4 * ARCSEC, "N": 3 * ARCSEC, "B": ARCSEC, "K": 0.09 * ARCSEC, "R": 0.002 * ARCSEC}
RLG: Terms = {"Q": 0.5 * ARCSEC, "N": 0.18 * ARCSEC, "B": 0.05 * ARCSEC}
CLEAN: dict[str, Terms] = {
    "mems": MEMS, "fog": FOG, "rlg": RLG, "N": {"N": 0.005}, "N+K": {"N": 0.005, "K": 1e-3},
    "strong N+K": {"N": 0.005, "K": 1e-2}, "Q+N": {"Q": 2e-4, "N": 0.002},
}  # fmt: skip


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
    "wave": (moves.waves, ""), "exponent": (moves.exponents, ""),
    **{f"factor: {kind}": (search.factors, kind) for kind in FACTORS},
}  # fmt: skip
"""Rows of the table of components by what is listed, how they are added, and the kind of a factor."""

TUNED = {"filter": 1, "resonance": 1, "warm-up": 3}
"""Rows whose alternatives are no shapes that are refined, and how often these are exchanged."""

NULLS: dict[str, tuple[Maker, str]] = {
    **{name: (lambda n, rng, of=noise: judge.sensor(n, RATE, rng, **of), "") for name, noise in CLEAN.items()},
    "fog behind rc fs/12": (filtered, "filter"),
    "mems beside a resonance": (resonant, "resonance"),
}
"""How a record is made, and the row of the component that it has beside noise."""
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


def gain_of(frame: Frame, bases: list[Fitted], row: str) -> float:
    """What a row gains in 2 L' with all powers free."""
    name, (move, kind) = row.partition(":")[0], ROWS[row]
    value = min(map(value_of, bases))
    with trying_all(kind):
        more = [f for base in bases for f in grown(frame, base, name, move)]
        more = [f for f in more if not kind or any(p.label == kind for p in f.state.of(name))]
    return value - min(map(value_of, more), default=value)


def gains_of(frame: Frame, beside: str) -> dict[str, float]:
    """What each row gains that may stand beside what is there."""
    bases = bases_of(frame, beside)
    rows = [row for row in ROWS if not row == beside == "filter" and (row != "floor" or beside == "filter")]
    return {row: gain_of(frame, bases, row) for row in rows} if bases else {}


def line_of(job: tuple[str, int, int]) -> Line:
    """What one record gains."""
    name, n, number = job
    make, beside = NULLS[name]
    record = al.Record(make(n, seeded(number, "prices", name, n)), rate=RATE, unit="deg/s", kind="rate")
    seen = spectrum(record, detrend=True)
    return n, gains_of(frame_of(seen, SYMBOLS, seen.read(None, ())), beside)


def places_of(row: str, gain: np.ndarray, share: float) -> float:
    """Independent places of which the best gains as much in a share of records; 0 where one place gains more."""
    component = COMPONENTS[row.partition(":")[0]]
    at = float(np.quantile(gain, 1 - share))
    single = float(chdtrc(1, max(at, 0.0))) * (1.0 if component.signed else 0.5)
    return math.log1p(-share) / math.log1p(-single) if single < 1 else 0.0


def gains_rows(lines: Sequence[Line]) -> list[Row]:
    """Quantiles of what each row gains, its price, and the places that follow."""
    rows, names = [], dict.fromkeys(row for _, gains in lines for row in gains)
    for row, n in product(names, dict.fromkeys(n for n, _ in lines)):
        gain = np.array([gains[row] for size, gains in lines if size == n and row in gains])
        kind = row.partition(": ")[2]
        price = FACTORS[kind] if kind else COMPONENTS[row].price(n)
        levels = (*np.quantile(gain, (0.5, 0.9, 0.97, 0.99)), gain.max(), price)
        places = (f"{places_of(row, gain, share):.2g}" for share in TAILS)
        now = "" if kind else f"{COMPONENTS[row].places(n):.3g}"
        rows.append((row, str(n), str(gain.size), *(f"{x:.1f}" for x in levels), shared(gain > price), *places, now))
    return rows


HEADINGS = (
    "row", "n", "records", "50 %", "90 %", "97 %", "99 %", "largest", "price", "above %",
    *(f"places, {100 * share:.0f} %" for share in TAILS), "places now",
)  # fmt: skip
NOTES = (
    SEEDS,
    "gain: how much lower 2 L' is with one such component more, all powers free; above: share of records in which it "
    "is above the price; places: effective ones, from the tenth of the records that gain most, and from 3 %",
)


def main() -> None:
    run = begin(__doc__ or "", short=80, usual=100, long=60, processes=2)
    asked, lines = run.asked, []
    for n, records in ((2**13, asked.short), (2**16, asked.usual), (2**18, asked.long)):
        for _, some in spread(line_of, ((name, n) for name in NULLS), records, asked.processes):
            lines += some
    run.publish("Prices of components", NOTES, section("Gains", HEADINGS, gains_rows(lines)))


if __name__ == "__main__":
    main()

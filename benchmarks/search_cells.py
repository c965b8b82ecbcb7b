"""What the default identification says of simulated records of many kinds, by one code or another.

    python benchmarks/search_cells.py list [--cells GLOB ...]
    python benchmarks/search_cells.py run [--cells GLOB ...] [--records A:B] --out FILE.jsonl
    python benchmarks/search_cells.py table OLD.jsonl [NEW.jsonl]

The interpreter chooses the code. `run` appends a line of JSON for each record, and leaves out what FILE has already;
`table` has a row for each cell and file, of the records that both have. The records are those of `independent`: the
seed is the CRC-32 of the cell's name, and the number of the record.
"""

from table import markdown

import argparse
import json
import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

import allanite as al
import independent as sim
from allanite.study.noise import noise_of
from search_table import rows_of

RATE, SIZE, SETTLING, FAST = 100.0, 2**16, 8192, 8
"""Rate, Hz, and samples of most records; samples in which filters forget their start; the rate before an analog
filter, over that of the record."""

READ = 0.005  # how well N of a rounded record is known, of itself: three times the scatter of the ratio of two spectra
RECORDS, FEW, LONG = 40, 10, 2**18  # records of a cell; of one of `LONG` samples or more

Truth = dict[str, Any]
Made = tuple[sim.Values, Truth]
Maker = Callable[[int, float, sim.Rng], Made]
Change = Callable[[sim.Values, sim.Rng], sim.Values]

ARCSEC = 1 / 3600
MEMS: Truth = {"N": 0.005, "B": 0.002, "K": 3e-4}
FOG: Truth = {"Q": 0.4 * ARCSEC, "N": 3 * ARCSEC, "B": ARCSEC, "K": 0.09 * ARCSEC, "R": 0.002 * ARCSEC}
RLG: Truth = {"Q": 0.5 * ARCSEC, "N": 0.18 * ARCSEC, "B": 0.05 * ARCSEC}
PLAIN: Truth = {"N": 0.005, "B": 0.002}
SHAKEN: Truth = {"N": 0.005, "B": 0.004}
WHITE = 0.005 * math.sqrt(RATE)
"""Standard deviation of the white noise of `MEMS`, `PLAIN` and `SHAKEN`, deg/s."""


@dataclass(frozen=True)
class Cell:
    """How a record is made; terms that are no error where they are claimed; at most so many records (0: the usual)."""

    make: Maker
    size: int = SIZE
    rate: float = RATE
    allowed: str = ""
    most: int = 0

    @property
    def records(self) -> int:
        """How many records are made."""
        return self.most or (FEW if self.size >= LONG else RECORDS)


def plain(noise: Truth) -> Maker:
    """A sensor, deg and s."""
    return lambda n, rate, rng: (sim.sensor(n, rate, rng, **noise), dict(noise))


def digital(noise: Truth, *filters: sim.Filter) -> Maker:
    """A sensor behind digital filters at the rate of the record."""

    def make(n: int, rate: float, rng: sim.Rng) -> Made:
        y = sim.behind(sim.sensor(n + SETTLING, rate, rng, **noise), filters)[SETTLING:]
        return y, dict(noise, N=noise["N"] * math.sqrt(sim.folded(filters)))

    return make


def analog(noise: Truth, *filters: sim.Filter) -> Maker:
    """A sensor behind filters at `FAST` times the rate, sampled; N with what is folded down to zero frequency."""

    def make(n: int, rate: float, rng: sim.Rng) -> Made:
        fast, settling = FAST * rate, SETTLING // FAST
        raw = dict(noise, Q=noise.get("Q", 0.0) * math.sqrt(FAST))  # of the same density
        raw = {symbol: size for symbol, size in raw.items() if size}
        y = sim.behind(sim.sensor(FAST * (n + settling), fast, rng, finer=1, **raw), filters)
        power = noise["N"] ** 2 * sim.folded(filters, FAST)
        if "Q" in raw:
            power += raw["Q"] ** 2 * fast * sim.folded([*filters, ([1.0, -1.0], [1.0])], FAST)
        return y[FAST - 1 :: FAST][settling:], dict(noise, N=math.sqrt(power))

    return make


def after(make: Maker, change: Change) -> Maker:
    """A record that something happens to."""

    def changed(n: int, rate: float, rng: sim.Rng) -> Made:
        y, known = make(n, rate, rng)
        return change(y, rng), known

    return changed


def gauss_markov(sigma: float, share: float) -> Maker:
    """N and a Gauss-Markov process whose time constant is a share of the record."""
    return lambda n, rate, rng: plain({"N": 0.005, "GM": ((sigma, share * n / rate),)})(n, rate, rng)


def low_cost(N: float, rate: float, cutoff: float, step: float) -> Maker:
    """White noise behind a second-order low-pass, Hz, rounded to a step about an offset."""
    behind = analog({"N": N}, sim.butterworth(cutoff / rate / FAST))
    return with_rounding(behind, step, 5.0, (0.005, cutoff / rate / 5))


def with_rounding(make: Maker, step: float, offset: float, band: tuple[float, float]) -> Maker:
    """A record rounded to a step; N is that of the rounded record, and is known to `READ`."""

    def changed(n: int, rate: float, rng: sim.Rng) -> Made:
        x, known = make(n, rate, rng)
        x = x + rng.uniform(-offset, offset)
        y = sim.rounded(x, step)
        N = known["N"] * math.sqrt(sim.regained(x, y, *band))
        return y, known | {"N": (N * (1 - READ), N * (1 + READ))}

    return changed


def shaking(squared: bool, *which: tuple[float, float, float]) -> Maker:
    """An accelerometer beside resonances: frequency, cycles per sample, quality, and peak over the white noise."""

    def make(n: int, rate: float, rng: sim.Rng) -> Made:
        y, known = plain(SHAKEN)(n, rate, rng)
        level = SHAKEN["N"] * math.sqrt(rate)
        for f, quality, peak in which:
            y = y + level * sim.resonance(n + SETTLING, f, quality, peak, rng, squared=squared)[SETTLING:]
        return y, known

    return make


def bumped(share: float) -> Maker:
    """MEMS with a hump of an octave about 3 % of the rate."""

    def make(n: int, rate: float, rng: sim.Rng) -> Made:
        y = sim.hump(sim.sensor(n + SETTLING, rate, rng, **MEMS), share, 0.03)
        return y[SETTLING // 2 : n + SETTLING // 2], dict(MEMS)

    return make


def repeated(*times: int) -> Maker:
    """MEMS slower than the logger, each value held so many times; N of the record, where the number varies."""

    def make(n: int, rate: float, rng: sim.Rng) -> Made:
        mean, square = np.mean(times), np.mean(np.square(times))
        y = sim.held(sim.sensor(int(n / mean * 1.1) + 100, rate / mean, rng, **MEMS), times, n, rng)
        return y, dict(MEMS, N=MEMS["N"] * math.sqrt(square) / mean)

    return make


def heavy(n: int, rate: float, rng: sim.Rng) -> Made:
    """MEMS whose white noise has the tails of Student's distribution of 4 degrees of freedom."""
    slow = {symbol: size for symbol, size in MEMS.items() if symbol != "N"}
    return sim.student(n, MEMS["N"], rate, 4.0, rng) + sim.sensor(n, rate, rng, **slow), dict(MEMS)


CLEAN: dict[str, Truth] = {
    "mems": MEMS, "fog": FOG, "rlg": RLG, "N": {"N": 0.005}, "N+K": {"N": 0.005, "K": 1e-3},
    "strong N+K": {"N": 0.005, "K": 1e-2}, "Q+N": {"Q": 2e-4, "N": 0.002},
}  # fmt: skip
BEHIND: dict[str, Callable[[Truth], Maker]] = {
    **{f"rc {name}": lambda noise, c=c: digital(noise, sim.rc(c))
       for name, c in (("fs/12", 1 / 12), ("fs/4", 1 / 4), ("0.45 fs", 0.45))},
    **{f"averaged rc {name}": lambda noise, c=c: analog(noise, sim.rc(c / FAST), sim.average(FAST))
       for name, c in (("fs/12", 1 / 12), ("fs/4", 1 / 4))},
    **{f"butterworth fs/{k}": lambda noise, k=k: analog(noise, sim.butterworth(1 / k / FAST)) for k in (6, 12)},
    **{f"digital butterworth fs/{k}": lambda noise, k=k: digital(noise, sim.butterworth(1 / k)) for k in (6, 12)},
    **{f"average {m}": lambda noise, m=m: digital(noise, sim.average(m)) for m in (2, 3, 5, 9)},
    "average twice 4": lambda noise: digital(noise, sim.average(4), sim.average(4)),
    "bartlett 2.75": lambda noise: analog(noise, sim.average(22), sim.average(22)),
    "cic3 2": lambda noise: analog(noise, *[sim.average(2 * FAST)] * 3),
}  # fmt: skip
CUTOFFS = ((100, (10, 20, 42)), (200, (10, 20, 42)), (500, (10, 20, 42, 98)), (1000, (10, 20, 42, 98)))
RESONANCES: dict[str, tuple[tuple[float, float, float], ...]] = {
    "2 resonances": ((0.17, 30, 200), (0.31, 60, 200)),
    "3 resonances": ((0.07, 20, 30), (0.19, 40, 100), (0.33, 15, 50)),
    "3 broad": ((0.12, 4, 15), (0.22, 5, 15), (0.36, 8, 15)),
    "4 resonances": ((0.1, 10, 60), (0.16, 25, 60), (0.27, 6, 60), (0.4, 70, 60)),
    "6 resonances": ((0.03, 30, 200), (0.08, 15, 60), (0.14, 40, 100), (0.21, 8, 20), (0.33, 25, 50), (0.42, 60, 10)),
}
TWO = {"N": 0.005, "B": 0.001, "GM": ((0.01, 2.0), (0.008, 40.0))}
TEN = {"N": 0.005, "B": 0.001, "GM": ((0.008, 10.0),)}
QUICK = {"N": 0.005, "GM": ((0.03, 5 / RATE),)}

CELLS: dict[str, Cell] = {
    **{f"clean/{name}": Cell(plain(noise)) for name, noise in CLEAN.items()},
    **{f"clean/{name} 2^{k}": Cell(plain(CLEAN[name]), 2**k)
       for name, k in (("mems", 13), ("fog", 13), ("N", 13), ("mems", 18), ("fog", 18), ("rlg", 18), ("mems", 20),
                       ("fog", 20))},
    **{f"filter/{name} {row}": Cell(make(noise))
       for name, noise in (("mems", MEMS), ("fog", FOG)) for row, make in BEHIND.items()},
    "filter/rlg rc fs/12": Cell(BEHIND["rc fs/12"](RLG)),
    "filter/gm 10 s rc fs/12": Cell(BEHIND["rc fs/12"](TEN)),
    **{f"filter/N rc {c} fs, 3 min": Cell(digital({"N": 0.0367}, sim.rc(c)), 18_000) for c in (0.39, 0.45, 0.6)},
    **{f"filter/fog rc fs/12 2^{k}": Cell(BEHIND["rc fs/12"](FOG), 2**k) for k in (13, 18)},
    "filter/mems butterworth fs/12 2^18": Cell(BEHIND["butterworth fs/12"](MEMS), 2**18),
    **{f"gyro/{rate} Hz, {cutoff} Hz, 1:{counts}":
       Cell(low_cost(0.004, rate, cutoff, 1 / counts), 300 * rate, rate, most=4)
       for rate, cutoffs in CUTOFFS for cutoff in cutoffs for counts in (131, 65.5, 16.4)},
    **{f"hump/{share} % 2^{k}": Cell(bumped(share / 100), 2**k) for share in (5, 28) for k in (16, 18)},
    **{f"gm/n:{k}": Cell(gauss_markov(0.006, 1 / k)) for k in (200, 50, 20, 10)},
    "gm/n:50 2^18": Cell(gauss_markov(0.006, 1 / 50), 2**18),
    "gm/10 s": Cell(plain(TEN)),
    "gm/two": Cell(plain(TWO)),
    "gm/5 samples": Cell(plain(QUICK)),
    **{f"held/{m}": Cell(repeated(m)) for m in (2, 3, 4)},
    "held/2 to 5": Cell(repeated(2, 3, 4, 5)),
    **{f"steps/{k}": Cell(after(plain(PLAIN), lambda y, rng, k=k: sim.stepped(y, 0.4 * WHITE, k, rng)),
                          allowed="K GM" if k == 10 else "") for k in (1, 3, 10)},
    "start/warm-up": Cell(after(plain(PLAIN), lambda y, rng: sim.warmed(y, WHITE, 0.08 * y.size)), allowed="R"),
    "start/handled": Cell(after(plain(PLAIN), lambda y, rng: sim.handled(y, 30 * WHITE, 400, rng))),
    **{f"shaken/{name}, {kind}": Cell(shaking(kind == "sin^2", *which))
       for name, which in RESONANCES.items() for kind in ("poles", "sin^2")},
    "shaken/hump of quality 3": Cell(shaking(True, (1 / 3, 3, 9))),
    "shaken/4 resonances, poles 2^20": Cell(shaking(False, *RESONANCES["4 resonances"]), 2**20),
    "shaken/bursts": Cell(after(plain(MEMS), lambda y, rng: sim.bursting(y, 2 * WHITE, 0.05, (0.2, 0.26), rng))),
    "values/student": Cell(heavy),
    "values/clipped 2 %": Cell(after(plain(MEMS), lambda y, rng: sim.clipped(y, 0.02))),
    "values/popcorn": Cell(after(plain(PLAIN), lambda y, rng: sim.popping(y, 0.2 * WHITE, 2000, rng)), allowed="GM"),
    **{f"values/rounded {sigma:g} sigma": Cell(with_rounding(plain(MEMS), sigma * WHITE, WHITE, (0.05, 0.4)))
       for sigma in (0.3, 1.0, 3.0)},
}  # fmt: skip
"""Records by name; ":" divides."""


def finite(x: float | None) -> float | None:
    """A number that JSON has; else none."""
    return None if x is None or not math.isfinite(x) else float(x)


def described(noise: Any) -> dict[str, Any]:
    """What was said of a record, as plain data."""
    fit, scope = noise.fit, getattr(noise.fit, "scope", None)
    low_pass, residuals = getattr(scope, "filter", None), getattr(noise, "residuals", None)
    findings = (*fit.findings, *(residuals.findings if residuals is not None else ()))
    terms = {}
    for e in fit:
        low, high = e.interval(0.95) if e.limits is not None else (math.nan, math.nan)
        numbers = {"value": e.value, "low": low, "high": high, "upper": e.upper}
        terms[e.symbol] = {"status": e.status, **{key: finite(x) for key, x in numbers.items()}, "shape": list(e.shape)}
    return {
        "validity": noise.validity,
        "terms": terms,
        "filter": None if low_pass is None else [str(low_pass.row), finite(low_pass.cutoff)],
        "misfit": finite(getattr(scope, "misfit", 0.0)),
        "findings": sorted({str(finding.name) for finding in findings}),
        "said": [str(sentence) for sentence in getattr(scope, "sentences", ())],
        "notes": [str(note) for note in fit.notes],
    }


def answered(name: str, index: int) -> dict[str, Any]:
    """The line of one record; the truth in SI."""
    cell = CELLS[name]
    rng = np.random.default_rng((crc32(name.encode()), index))
    y, truth = cell.make(cell.size, cell.rate, rng)
    known = {s: np.radians(x).tolist() for s, x in truth.items() if s != "GM"}
    known |= {"GM": [[math.radians(sigma), T] for sigma, T in truth["GM"]]} if "GM" in truth else {}
    line = {"cell": name, "index": index, "n": cell.size, "rate": cell.rate, "truth": known, "allowed": cell.allowed}
    begin = time.process_time()
    try:
        noise = noise_of(al.Record(y, rate=cell.rate, unit="deg/s", kind="rate"), al.Recipe())
        validity = noise.validity
    except Exception as error:  # a record that fails is a line, not the end
        return line | {"cpu": time.process_time() - begin, "error": repr(error)[:300]}
    return line | {"cpu": time.process_time() - begin} | described(noise) | {"validity": validity}


def lines_of(path: Path) -> Iterator[dict[str, Any]]:
    """The lines of a file; one that was cut off is left out."""
    for text in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        try:
            yield json.loads(text)
        except json.JSONDecodeError:
            continue


def chosen(globs: Iterable[str]) -> list[str]:
    """Names of the cells that one of the patterns fits."""
    return [name for name in CELLS if any(fnmatchcase(name, glob) for glob in globs)]


def run(names: Iterable[str], first: int, last: int, path: Path) -> None:
    """Append the records that a file lacks: the first of every cell, then the second."""
    names, done = list(names), {(line["cell"], line["index"]) for line in lines_of(path)}
    warm, _ = CELLS["clean/N 2^13"].make(2**13, RATE, np.random.default_rng(0))
    noise_of(al.Record(warm, rate=RATE, unit="deg/s", kind="rate"), al.Recipe())  # compiled code is loaded
    print(f"code of {Path(al.__file__).parent}", file=sys.stderr)
    with path.open("a", encoding="utf-8") as out:
        for index in range(first, last):
            for name in names:
                if index < CELLS[name].records and (name, index) not in done:
                    out.write(json.dumps(answered(name, index)) + "\n")
                    out.flush()


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = parser.add_subparsers(dest="verb", required=True)
    for verb in ("list", "run"):
        asked = verbs.add_parser(verb)
        asked.add_argument("--cells", nargs="+", default=["*"])
    asked.add_argument("--records", default=f"0:{RECORDS}")
    asked.add_argument("--out", type=Path, required=True)
    verbs.add_parser("table").add_argument("files", type=Path, nargs="+")
    given = parser.parse_args()
    if given.verb == "table":
        headings, rows = rows_of({path.stem: list(lines_of(path)) for path in given.files})
        print("\n".join(markdown(headings, rows)))
        return
    names = chosen(given.cells)  # a name may have a comma
    if given.verb == "list":
        print("\n".join(f"{name:40} {CELLS[name].records:3} records of {CELLS[name].size}" for name in names))
        return
    first, last = map(int, given.records.split(":"))
    run(names, first, last, given.out)


if __name__ == "__main__":
    main()

"""Terms that are looked for when they are asked for: how often found, bias and coverage of their limits.

Each cell has seeds of its own. Records of 2^16 samples at 20 Hz are simulated and identified with the terms named; the
limits of every coefficient, time constant, frequency and damping are those of 95 %. A second line of each cell counts
false findings of the new term in records of the same model without it.

Records of 2^14 samples, with W of 80 s (commit f6702ca), were too short for GMA: it was found in 67.7 ± 2.7 %, its
limits held in 90.1 ± 2.1 %, those of T in 89.7 ± 2.1 %, and T was 14 % too small.
"""

from table import begin, markdown, shared

import sys
from dataclasses import dataclass

import numpy as np

import allanite as al

RATE, SIZE, LEVEL = 20.0, 2**16, 0.95
QN = al.Q(0.3, "arcsec") + al.N(0.05, "deg/sqrt(h)")
NB = al.N(0.05, "deg/sqrt(h)") + al.B(1.0, "deg/h")
HEADINGS = ("cell", "records", "parameter", "truth", "found, %", "bias, %", "spread / bound", "coverage, %", "false, %")


@dataclass(frozen=True)
class Cell:
    """A model, what is asked for, and the first of its seeds."""

    rest: al.Model
    extra: al.Term
    terms: str
    seed: int

    @property
    def model(self) -> al.Model:
        """The whole model."""
        return self.rest + self.extra


PROCESS = al.N(0.05, "deg/sqrt(h)") + al.GM(20.0, "deg/h", time_constant=2.0)
LOOP = al.N(0.05, "deg/sqrt(h)") + al.GM(20.0, "deg/h", time_constant=60.0)
SLOW = al.GML(20.0, "deg/h", time_constant=60.0)
ONE = (
    Cell(QN, al.F(1.0, "arcsec"), "QFN", 10_000),
    Cell(NB, al.W(20.0, "deg/h", time_constant=300.0), "NBKW", 20_000),
    Cell(QN, al.GMA(3.0, "arcsec", time_constant=2.0), "Q,N,GMA", 30_000),
    Cell(NB, al.GM2(20.0, "deg/h", frequency=0.3, damping=0.15), "N,B,GM2", 40_000),
)
TWO = (
    Cell(PROCESS, SLOW, "N,GM,GM", 50_000),
    Cell(PROCESS, al.GML(30.0, "deg/h", time_constant=60.0), "QNBKR,GM,GM", 60_000),
    Cell(LOOP, al.GM2(20.0, "deg/h", frequency=0.3, damping=0.15), "N,GM,GM2", 70_000),
)
CELLS = {"one": ONE, "two": TWO}  # cells by the number of terms with a shape that are asked for


def identified(model: al.Model, terms: str, seed: int) -> al.Fit:
    """The fit of one record."""
    return al.identify(al.simulate(model, SIZE, RATE, rng=np.random.default_rng(seed)), terms=terms)


def parameters(estimate: al.Estimate) -> list[tuple[float, float, float]]:
    """Value and limits of the coefficient, and of each parameter of the shape."""
    found = [(estimate.value, *estimate.interval(LEVEL))]
    if estimate.shape_limits:
        found += [(v, *ends) for v, ends in zip(estimate.shape, estimate.shape_limits(LEVEL), strict=True)]
    return found


def rows(cell: Cell, records: int) -> list[tuple[str, ...]]:
    """The lines of a cell: the new term's parameters, then the other coefficients."""
    symbol = cell.extra.symbol
    fits = [identified(cell.model, cell.terms, cell.seed + i) for i in range(records)]
    few = max(records // 3, 10)
    empty = [identified(cell.rest, cell.terms, cell.seed + records + i) for i in range(few)]
    false = shared([fit[symbol].claimed for fit in empty])
    bound = al.bound(cell.model, SIZE, RATE)
    lines = []
    for term in (cell.extra, *cell.rest):
        names = [term.symbol, *(f"{term.symbol} {p.title}" for p in term.row.parameters)]
        claimed = np.array([fit[term.symbol].claimed for fit in fits])
        values = np.array([parameters(fit[term.symbol]) for fit, ok in zip(fits, claimed, strict=True) if ok])
        for i, (name, truth) in enumerate(zip(names, (term.value, *term.shape), strict=True)):
            value, low, high = values[:, i].T
            lines.append((
                str(cell.model), str(records), name, f"{truth:.4g}", shared(claimed),
                f"{100 * (value.mean() / truth - 1):+.1f}",
                f"{value.std() / truth / bound[name]:.2f}", shared((low <= truth) & (truth <= high)),
                false if term is cell.extra and not i else "",
            ))  # fmt: skip
    return lines


def main() -> None:
    run = begin(__doc__, cells="one", records=300)
    lines, cells = [], CELLS[run.asked.cells]
    for cell in cells:
        lines += rows(cell, run.asked.records)
        print(*("\t".join(line[2:]) for line in lines[-6:]), sep="\n", file=sys.stderr, flush=True)
    run.publish(
        "Terms that are asked for",
        [
            f"Records of {SIZE} samples at {RATE:g} Hz; seeds from {', '.join(str(c.seed) for c in cells)} on.",
            "found: share of the records in which the term is reported; truth is in SI; bias and spread are of these, "
            "spread over the Cramér-Rao bound of the whole model; coverage is that of the 95 % limits; false: share of "
            "a third as many records without the term in which it is reported.",
        ],
        markdown(HEADINGS, lines),
    )


if __name__ == "__main__":
    main()

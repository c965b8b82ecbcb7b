"""Limits of curves and of coefficients whose noise is identified from the same record, against the truth.

Nothing is told of the noise: each record is identified by "auto", and the limits of its curves are averaged over the
models that it leaves open. Beside them the limits that take the selected model for the truth, and those of allantools
with the power law that it finds at each averaging time. Every cell has seeds of its own: the number of the noise, of
samples, and of the record.
"""

from table import Row, begin, covered, markdown, spread

import contextlib
import io
import math
import os
import warnings
from argparse import Namespace
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

import allanite as al
from allanite.statistics import STATISTICS

N = al.N(1, "deg/sqrt(h)")
NOISES: dict[str, al.Model] = {
    "N+K": N + al.K(60, "deg/h/sqrt(h)"),
    "N+weak K": N + al.K(15, "deg/h/sqrt(h)"),
    "N+B+K": N + al.B(6, "deg/h") + al.K(30, "deg/h/sqrt(h)"),
    "Q+N+B": al.Q(30, "arcsec") + N + al.B(5, "deg/h"),
    "Q+N+B+K+R": al.Q(30, "arcsec") + N + al.B(5, "deg/h") + al.K(30, "deg/h/sqrt(h)") + al.R(60, "deg/h^2"),
    "Q+K": al.Q(30, "arcsec") + al.K(4, "deg/h/sqrt(h)"),
}
"""At 1 Hz."""

TO_A_FIFTH, TO_0_3, TO_HALF, TO_0_8 = (0.1, 0.2), (0.1, 0.2, 0.3), (0.1, 0.2, 0.4, 0.5), (0.1, 0.2, 0.4, 0.5, 0.8)
STATISTIC = {
    "oadev": TO_HALF, "hdev": TO_A_FIFTH, "mdev": TO_A_FIFTH, "pdev": TO_HALF, "totdev": TO_0_8,
    "mtotdev": TO_0_3, "htotdev": TO_0_3, "theo1": TO_HALF, "theobr": TO_HALF, "theoh": TO_HALF,
}  # fmt: skip
"""Each with averaging times that it reaches, shares of the record."""

EXACT = ("totdev", "mtotdev", "htotdev", "theo1")  # statistics whose bias is divided out
PEERS = ("oadev", "hdev", "mdev", "totdev")  # statistics whose limits allantools gives

LEVELS = (0.95, 0.68)


@dataclass(frozen=True)
class Said:
    """What was said at one averaging time: place of the truth, -1 below the limits, 0 within, 1 above, and their ratio.

    A row for each of the levels.
    """

    place: tuple[int, ...]
    width: tuple[float, ...]


def factors_of(name: str, size: int) -> list[int]:
    """Averaging factors, even, at the shares of the record that a statistic reaches."""
    factor = STATISTICS[name].tau_factor
    return [2 * int(share * size / factor / 2) for share in STATISTIC[name]]


def curves_of(job: tuple[str, int, int]) -> dict[tuple[str, str, int], Said]:
    """What was said of one record, by kind of limits, statistic and averaging factor."""
    name, size, i = job
    model = NOISES[name]
    rng = np.random.default_rng((list(NOISES).index(name), size, i))
    record = al.simulate(model, size, 1.0, rng=rng)
    fit = al.identify(record)
    found = {}
    for statistic in STATISTIC:
        m = factors_of(statistic, size)
        bias = "exact" if statistic in EXACT else None
        target = STATISTICS[statistic].target or statistic
        for kind, noise in (("averaged", fit), ("selected", fit.model)):
            curve = al.deviation(record, statistic, m=m, noise=noise, bias=bias)
            truth = np.sqrt(al.expected(model, target, curve.tau, rate=None if target == "oadev" else 1.0, size=size))
            limits = [curve.interval(level) for level in LEVELS]
            for j, k in enumerate(m):
                found[kind, statistic, k] = _said(truth[j], [(low[j], high[j]) for low, high in limits])
        if statistic in PEERS:
            for j, (k, limits_there) in enumerate(zip(m, _peer(record, statistic, m), strict=True)):
                found["allantools", statistic, k] = _said(truth[j], limits_there)
    return found


def _said(truth: float, limits: list[tuple[float, float]]) -> Said:
    place = tuple(-1 if truth < low else int(truth > high) for low, high in limits)
    return Said(place, tuple(high / low if low else math.inf for low, high in limits))


def _peer(record: al.Record, statistic: str, m: list[int]) -> Iterator[list[tuple[float, float]]]:
    """Limits of allantools by the noise that it identifies, at both levels."""
    import allantools

    phase = np.concatenate(([0.0], np.cumsum(np.asarray(record.values) - np.mean(record.values)))) * record.rate_factor
    function = getattr(allantools, statistic)
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        for k in m:
            try:
                dev = function(phase, rate=1.0, data_type="phase", taus=[float(k)])[1]
                yield _peer_limits(phase, float(dev[0]), k, statistic)
            except (UserWarning, NotImplementedError, AssertionError):  # too few windows for it
                yield [(math.nan, math.nan) for _ in LEVELS]


def _peer_limits(phase: np.ndarray, dev: float, m: int, statistic: str) -> list[tuple[float, float]]:
    """By the power law at m, or at the longest m that its identification takes: 30 points."""
    from allantools import ci

    degree, size = (3 if statistic == "hdev" else 2), phase.size - 1
    alpha = ci.autocorr_noise_id(phase, min(m, size // 31), data_type="phase", dmin=0, dmax=degree)[0]
    if statistic == "totdev":
        edf = ci.edf_totdev(phase.size, m, alpha)
    else:
        kind = {"overlapping": statistic != "hdev", "modified": statistic == "mdev"}
        edf = ci.edf_greenhall(alpha=alpha, d=degree, m=m, N=phase.size, **kind)
    return [tuple(map(float, ci.confidence_interval(dev, edf, level))) for level in LEVELS]


KINDS = ("averaged", "selected", "allantools")


def curve_rows(name: str, size: int, answers: list[dict[tuple[str, str, int], Said]]) -> Iterator[Row]:
    """A row for each statistic and averaging time of a noise and length."""
    for statistic in STATISTIC:
        for k in factors_of(statistic, size):
            keys = [(kind, statistic, k) for kind in KINDS]
            cells = [cell for key in keys for cell in _kind([answer[key] for answer in answers if key in answer])]
            yield (name, str(size), statistic, f"{k * STATISTICS[statistic].tau_factor / size:.2f}", *cells)


def _kind(said: list[Said]) -> tuple[str, str, str]:
    """Coverage at 95 % with what lies above and below, at 68 %, and the median ratio of the limits at 95 %."""
    known = [one for one in said if not math.isnan(one.width[0])]
    if not known:
        return "", "", ""
    place = np.array([one.place for one in known])
    ratio = f"{np.median([one.width[0] for one in known]):.3g}"
    return covered(place[:, 0]), f"{100 * (place[:, 1] == 0).mean():.1f}", ratio


@dataclass(frozen=True)
class Cell:
    """A noise at a rate, Hz, for a number of samples; its noise of the angle by rounding, if that is asked."""

    model: al.Model
    rate: float
    size: int
    rounded: bool = False


MEMS = al.N(0.005, "deg/sqrt(s)") + al.B(0.002, "deg/s") + al.K(3e-4, "deg/s/sqrt(s)")
CELLS: dict[str, Cell] = {
    "only N": Cell(al.Model((al.N(1, "deg/sqrt(h)"),)), 1.0, 4096),
    "N+K": Cell(NOISES["N+K"], 1.0, 4096),
    "N+B": Cell(N + al.B(10, "deg/h"), 1.0, 16384),
    "telephone 5 Hz, 1 h": Cell(al.N(0.4, "deg/sqrt(h)") + al.B(10, "deg/h") + al.K(60, "deg/h/sqrt(h)"), 5.0, 18000),
    "accelerometer": Cell(al.N(0.1, "m/s/sqrt(h)") + al.B(0.05, "mg") + al.K(0.1, "mg/sqrt(h)"), 100.0, 65536),
    "N+B+K, 500": Cell(NOISES["N+B+K"], 1.0, 500),
    "N+B+K, 1000": Cell(NOISES["N+B+K"], 1.0, 1000),
    "N+B+K, 3000": Cell(NOISES["N+B+K"], 1.0, 3000),
    "edge K": Cell(N + al.K(25, "deg/h/sqrt(h)"), 1.0, 4096),
    "edge B": Cell(N + al.B(6, "deg/h"), 1.0, 8192),
    "Q+N, rounded": Cell(al.Q(35, "arcsec") + N, 1.0, 4096, rounded=True),
    "all five, 1 Hz": Cell(NOISES["Q+N+B+K+R"], 1.0, 16384),
    "navigation RLG": Cell(al.Q(0.5, "arcsec") + al.N(0.003, "deg/sqrt(h)") + al.B(0.01, "deg/h"), 10.0, 65536),
    "tactical MEMS": Cell(MEMS, 100.0, 65536),
    "N+GM": Cell(N + al.GM(20, "deg/h", time_constant=100), 1.0, 16384),
    "N+B+GM": Cell(N + al.B(4, "deg/h") + al.GM(20, "deg/h", time_constant=100), 1.0, 16384),
}


TIME = "time constant"


def coefficients_of(job: tuple[str, int]) -> dict[str, tuple[float, ...]]:
    """Of each true term: median over truth, whether claimed, whether its limits at 95 and 68 % hold it.

    And the same ratio with the terms known, and by least squares. Of the others: whether claimed. Terms that are not
    valid or not observable count for nothing.
    """
    name, i = job
    cell = CELLS[name]
    rng = np.random.default_rng((100 + list(CELLS).index(name), cell.size, i))
    record = al.simulate(cell.model, cell.size, cell.rate, rng=rng, rounding=cell.rounded)
    truth = {t.symbol: t.value for t in cell.model}
    fit = al.identify(record)
    known = al.identify(record, terms=",".join(truth))
    squares = al.identify(record, terms=",".join(s for s in truth if s != "GM"), method="ls")
    found: dict[str, tuple[float, ...]] = {}
    for e in fit:
        if e.symbol not in truth:
            found[e.symbol] = (float(e.claimed),)
        elif e.median is not None and e.status not in ("not observable", "not valid"):
            true = truth[e.symbol]
            other = squares[e.symbol].value or 0.0 if e.symbol != "GM" else math.nan
            ratios = (e.median / true, (known[e.symbol].median or 0.0) / true, other / true)
            found[e.symbol] = (*ratios, float(e.claimed), *_held(true, map(e.interval, LEVELS)))
            if e.shape:
                (true,) = next(t.shape for t in cell.model if t.symbol == e.symbol)
                limits = [e.shape_limits(level)[0] for level in LEVELS] if e.shape_limits else []
                found[TIME] = (e.shape[0] / true, math.nan, math.nan, 1.0, *_held(true, limits))
    return found


def _held(true: float, limits: Iterable[tuple[float, float]]) -> list[float]:
    return [float(low <= true <= high) for low, high in limits]


def coefficient_rows(name: str, answers: list[dict[str, tuple[float, ...]]]) -> Iterator[Row]:
    """A row for each true term of a cell."""
    model = CELLS[name].model
    least = al.bound(model, CELLS[name].size, CELLS[name].rate)
    true = [t.symbol for t in model]
    false = [100 * np.mean([answer[s][0] for answer in answers if s in answer]) for s in "QNBKR" if s not in true]
    for symbol in (*true, TIME):
        numbers = np.array([answer[symbol] for answer in answers if symbol in answer])
        if not numbers.size:
            continue
        bound = float(least[symbol]) if symbol in true else math.nan
        shares = [f"{100 * share:.1f}" for share in numbers[:, 3:].mean(axis=0)]
        errors = [_over(ratio, bound) for ratio in numbers[:, :3].T]
        least_error = "" if math.isnan(bound) else f"{100 * bound:.1f}"
        yield (name, symbol, str(len(numbers)), least_error, *shares, *errors, f"{max(false, default=0.0):.1f}")


def _over(ratio: np.ndarray, bound: float) -> str:
    """Root mean square error over the bound."""
    error = math.sqrt(np.mean((ratio - 1) ** 2)) / bound
    return "" if math.isnan(error) else f"{error:.2f}"


def curves_asked(asked: Namespace) -> tuple[str, list[tuple[str, int]], list[str], tuple[str, ...]]:
    """Title, cells, notes and headings of the table of curves."""
    notes = [
        "seeds: number of the noise, samples, number of the record",
        f"{asked.records} records a cell; theobr and theoh with the model's bias, {', '.join(EXACT)} 'exact'",
        "95: % of records whose limits hold the truth (+ truth above, - below); 68: at 68 %; ratio: median upper "
        "over lower limit at 95 %",
    ]
    kinds = [f"{kind}: {what}" for kind in KINDS for what in ("95", "68", "ratio")]
    cells = [(name, 2**exponent) for name in asked.noises for exponent in asked.exponents]
    return "Limits of curves", cells, notes, ("noise", "samples", "statistic", "tau / T", *kinds)


def coefficients_asked(asked: Namespace) -> tuple[str, list[tuple[str]], list[str], tuple[str, ...]]:
    """The same of the table of coefficients."""
    notes = [
        "seeds: 100 and the number of the cell, samples, number of the record",
        f"{asked.records} records a cell, less those in which the term was said not to be valid",
        "95, 68: % of records whose limits hold the truth, `identify` with its defaults",
        "rms error of the median, claimed or not, over the Cramer-Rao bound with terms known; beside it those "
        "of the likelihood and of unweighted least squares on the Allan variance, both with terms known",
        "false: % of records, of the term most often claimed falsely",
    ]
    rms = ("rms", "rms, terms known", "rms, least squares")
    headings = ("noise", "term", "records", "bound, %", "claimed, %", "95", "68", *rms, "false, %")
    return "Limits of coefficients", [(name,) for name in CELLS], notes, headings


TABLES = {
    "curves": (curves_asked, curves_of, curve_rows),
    "coefficients": (coefficients_asked, coefficients_of, coefficient_rows),
}


def main() -> None:
    """Make a table."""
    run = begin(__doc__, what=tuple(TABLES), records=400, exponents=[10, 14], noises=list(NOISES),
                processes=os.cpu_count() or 1)  # fmt: skip
    about, work, rows_of = TABLES[run.asked.what]
    title, cells, notes, headings = about(run.asked)
    rows: list[Row] = []
    for cell, answers in spread(work, cells, run.asked.records, run.asked.processes):
        rows += rows_of(*cell, answers)
        print(*rows[-1], flush=True)
    run.publish(title, notes, markdown(headings, rows))


if __name__ == "__main__":
    main()

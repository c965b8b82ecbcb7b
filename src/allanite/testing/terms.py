"""A noise term against itself: its structure function, increments, spectrum, transform, states and simulation.

Everything is compared with the structure function D, and D with the numbers of its asymptote. A row is taken as it is:
in units of its sample interval, for a coefficient of 1. The columns say which checks a row is subject to.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import Any

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray
from allanite.core.model import Term
from allanite.core.units import BASES, SIGNALS, unit_of
from allanite.plugins import told
from allanite.simulation.record import simulate
from allanite.terms import TERMS
from allanite.terms.row import Block, NoiseTerm

from .checks import NONE, checking

NEAR = np.array([1.0, 2.0, 5.0, 30.0])
RATE = 3.0


def near(found: Any, exact: Any, rel: float = 1e-6, of: Any = None) -> None:
    """Equal up to `rel` of the largest value."""
    scale = np.max(np.abs(exact if of is None else of), initial=0.0)
    np.testing.assert_allclose(found, exact, rtol=rel, atol=rel * scale)


def fourth(D: Callable[[FloatArray], FloatArray], h: FloatArray) -> FloatArray:
    """Second moment of the first differences of the rate at the lags h, of the structure function."""
    return -0.5 * (6 * D(h) - 4 * D(np.abs(h - 1)) - 4 * D(h + 1) + D(np.abs(h - 2)) + D(h + 2))


def allan(row: NoiseTerm, m: Any) -> Any:
    """Allan variance over m samples."""
    return (4 * row.structure(m) - row.structure(2 * m)) / (2 * m**2)


def shaped(row: NoiseTerm, rate: float) -> NoiseTerm:
    """The row of its shape in seconds, at a sampling rate."""
    assert row.shaped is not None
    return row.shaped(row.shape, rate)


def at(row: NoiseTerm, rate: float) -> NoiseTerm:
    """The row where a unit of its time has `rate` samples."""
    return shaped(row, rate) if row.shaped else row


def rounding(row: NoiseTerm) -> float:
    """What differences of D lose."""
    return float(1e-14 * np.max(np.abs(row.structure(np.arange(66.0)))))


# the coefficient


def asymptote(row: NoiseTerm) -> None:
    """A straight line of `slope` through `level`, which has the value of the coefficient at `read_at`."""
    numbers = np.array([row.slope, row.level, row.read_at])
    assert np.isnan(numbers).all() or np.isfinite(numbers).all()
    if math.isnan(row.slope):
        return
    near(allan(row, 1.0), row.level)
    far = np.array([1e3, 2e3]) if not row.per_sample else np.array([1e8, 2e8])
    local = np.diff(np.log(allan(row, far))) / np.log(4.0)
    near(local, row.slope, 0.1 if row.per_sample else 1e-6, of=1.0)
    assert row.slope == -row.power
    crossed = 0 if row.per_sample or not row.slope else row.slope
    near(row.level ** (0.5 * bool(crossed)) * row.read_at ** (crossed or 1), 1.0)


def scaled(row: NoiseTerm) -> None:
    """The power of time in the coefficient and the power of the second in each parameter, by another unit of time."""
    other = at(row, RATE)
    for p, here, elsewhere in zip(row.parameters, row.shape, other.shape, strict=True):
        assert unit_of(p.unit or "1").dimension[BASES.index("time")] == p.time
        near(elsewhere, here * RATE**p.time)
    f = np.array([0.003, 0.1, 0.5])
    near(row.spectrum(f / RATE, RATE), RATE ** (1 - 2 * row.power) * row.spectrum(f, 1.0))
    if row.waveform is not None:
        assert other.waveform is not None
        fine = RATE**row.power * other.waveform(3 * 40)
        near(fine.reshape(40, 3).mean(axis=1), row.waveform(40))
    if row.transient:
        assert not row.per_sample
    else:  # the same in seconds at every rate, unless it begins with the sampling
        scales = np.allclose(RATE ** (2 * row.power) * allan(other, RATE * NEAR), allan(row, NEAR), rtol=1e-6)
        assert scales != row.per_sample


def law(row: NoiseTerm) -> None:
    """The exponent of the spectral density, where it has one."""
    f = np.array([1e-5, 1e-4, 1e-3])
    if row.alpha is not None:
        near(np.diff(np.log(row.spectrum(f, 1.0))) / np.log(10.0), row.alpha, 1e-3)


# functions of the time


def derivatives(row: NoiseTerm) -> None:
    """Each order by differences of the one below."""
    if row.transient:
        return
    for order in range(1, 8):
        below = row.structure if order == 1 else partial(row.derivative, order - 1)
        wide, close = ((below(NEAR + step) - below(NEAR - step)) / (2 * step) for step in (2e-3, 1e-3))
        lost = np.abs(1e-6 * close) + np.abs(1e-12 * below(NEAR))
        assert np.all(np.abs(row.derivative(order, NEAR) - (4 * close - wide) / 3) <= lost)


def sums(row: NoiseTerm) -> None:
    """The second sum of D, but for a constant."""
    if row.transient:
        return
    for first, rel in ((0.0, 1e-9), (4.37, 1e-5)):
        length = first + np.arange(40.0)
        D, E = row.structure(length), row.summed
        rest = E(length + 1) - 2 * E(length) + E(np.abs(length - 1)) - D
        near(rest - rest[-1], np.zeros(40), rel, of=D)


def increments(row: NoiseTerm) -> None:
    """Covariance of the differences of the rate; of a ramp the differences are constant, and have none."""
    if row.transient:
        return
    h = np.arange(60.0)
    moment = fourth(row.structure, h)
    if row.waveform is None or row.periodic:
        np.testing.assert_allclose(row.increments(h), moment, rtol=1e-6, atol=rounding(row))
    else:
        near(row.increments(h), np.zeros(60), of=1.0)


def oscillates(row: NoiseTerm) -> None:
    """The period of a covariance that changes its sign again and again."""
    if row.transient:
        assert row.period == 0
        return
    many = turns(row, np.geomspace(0.01, 1e4, 4000))
    assert (row.period > 0) == (many > 1 and not row.periodic)
    if row.period:  # damping makes it longer
        assert 4 <= turns(row, np.linspace(1e-3, 3, 1000) * row.period) <= 6


def turns(row: NoiseTerm, t: FloatArray) -> int:
    """How often the derivative of the covariance of the rate changes its sign."""
    third = np.sign(row.derivative(3, t))
    return int(np.count_nonzero(np.diff(third[third != 0])))


# functions of the frequency


@cache
def quadrature(panels: int = 40, nodes: int = 24) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights on (0, 1/2], finer towards 0."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    ends = np.append(0.5 * 0.75 ** np.arange(float(panels)), 0.0)
    half = -np.diff(ends) / 2
    return (ends[1:, None] + half[:, None] * (1 + x)).ravel(), (half[:, None] * w).ravel()


def spectra(row: NoiseTerm) -> None:
    """The integral of the spectral density of the differences is their covariance."""
    f, w = quadrature()
    h = np.arange(10.0)
    power = 2 * w * row.spectrum(f, 1.0) * 4 * np.sin(np.pi * f) ** 2
    exact = row.increments(h) if row.waveform is None else np.zeros(10)
    near(np.cos(2 * np.pi * np.outer(h, f)) @ power, exact, 1e-5, of=exact if row.waveform is None else [1.0])


def transforms(row: NoiseTerm, n: int = 61) -> None:
    """The diagonal of the covariance in the basis of the cosine transform, the ends of the record included."""
    from scipy.fft import dct

    k, lag = np.arange(1.0, n), np.arange(float(n))
    exact = np.zeros(n - 1)
    if row.waveform is None:
        C = 0.5 * (row.structure(lag + 1) - 2 * row.structure(lag) + row.structure(np.abs(lag - 1)))
        basis = dct(np.eye(n), axis=0, norm="ortho")[1:]
        whole = (C - C[0])[np.abs(np.subtract.outer(np.arange(n), np.arange(n)))]
        exact = np.einsum("ki,ij,kj->k", basis, whole, basis)
    ends = (row.edge + row.ends) * 4 / n * np.cos(np.pi * k / (2 * n)) ** 2
    atol = rounding(row) if row.waveform is None else 0.0
    off = np.maximum(np.abs(row.dct(k, n) + ends - exact) - atol, 0.0)
    assert np.all(off <= max(1e-6, row.dct_error) * np.abs(exact))
    assert 0 <= row.dct_error <= 1.5 * np.max(off / np.maximum(np.abs(exact), 1e-300))  # no more than it has to be


def waveforms(row: NoiseTerm) -> None:
    """A deterministic term begins to rise; what it is made of has the increments that D says."""
    if row.waveform is None:
        assert (row.periodic, row.transient) == (False, False)
        return
    assert (row.periodic, row.transient) != (True, True)
    phases = [x for p, x in zip(row.parameters, row.shape, strict=True) if p.default is not None]
    fine = at(row, 1000.0).waveform
    assert fine is not None
    assert np.diff(fine(2)) > 0 or any(phases)
    if row.transient:  # it begins with 0, and the coefficient is what it tends to
        near(row.waveform(10**6)[-1], 1.0)
        first = shaped(row, 1e6).waveform
        assert first is not None
        near(first(1), [0.0], of=1.0)
        for column in (row.structure, lambda t: row.derivative(1, t), row.summed, row.increments):
            assert refuses(column)
        return
    d, h = np.diff(row.waveform(20_000)), np.arange(3)
    products = [np.mean(d[: d.size - 3] * d[lag : d.size - 3 + lag]) for lag in h]
    near(products, fourth(row.structure, h.astype(float)), 0.01)


def refuses(column: Callable[[FloatArray], Any]) -> bool:
    """Whether a function says that there is nothing that it could return."""
    try:
        column(NEAR)
    except ValueError:
        return True
    return False


def states(row: NoiseTerm) -> None:
    """The differences of what a filter of these states measures have the moments that D says."""
    if row.block is None:
        return
    for rate, other in ((1.0, row), (RATE, at(row, RATE))):
        block = row.block(1.0, row.shape, 1 / rate)
        C = rate ** (-2 * row.power) * measured(block, 12)
        d = np.diff(np.eye(12), axis=0)
        moments = (d @ C @ d.T)[:, 5]
        moment = fourth(other.structure, np.abs(np.arange(11.0) - 5))
        np.testing.assert_allclose(moments, moment, rtol=1e-6, atol=rounding(other))
    continuous(row)


def measured(block: Block, n: int) -> FloatArray:
    """Covariance of the means over n intervals, shape (n, n)."""
    s, P, C = len(block.names), block.P0, np.zeros((n, n))
    for i in range(n):
        cross = P @ block.mean  # of the states at the start of the interval and its mean
        C[i, i] = block.mean @ cross + block.Q[s, s] + block.white
        after = block.Phi @ cross + block.Q[:s, s]
        for j in range(i + 1, n):
            C[i, j] = C[j, i] = block.mean @ after
            after = block.Phi @ after
        P = block.Phi @ P @ block.Phi.T + block.Q[:s, :s]
    return C


def continuous(row: NoiseTerm) -> None:
    """Over a short interval the transition is that of the continuous form (Van Loan, 1978), if it has one."""
    from scipy.linalg import expm

    assert row.block is not None
    block = row.block(1.0, row.shape, 1.0)
    F, Qc = block.F, block.Qc
    if not (Qc.any() or block.output.any()):
        return
    s, h = len(F), 0.1 / (1 + float(np.linalg.norm(F)))
    whole = expm(h * np.block([[-F, Qc], [np.zeros((s, s)), F.T]]))
    block, Phi = row.block(1.0, row.shape, h), whole[s:, s:].T
    near(block.Phi, Phi)
    near(block.Q[:s, :s], Phi @ whole[:s, s:], of=Qc * h)


def simulated(row: NoiseTerm, n: int = 64, count: int = 100) -> None:
    """Records of the term have the waveform, or the moments of the increments."""
    with TERMS.trying(row.symbol, row):
        term, rng = Term(row.symbol, 1.0, SIGNALS[0], row.shape), np.random.default_rng(1)
        records = [simulate(term, n, RATE, rng=rng).values for _ in range(count if row.waveform is None else 1)]
        sampled, size = term.sampled(RATE), term.power(RATE)
    if sampled.waveform is not None:
        wave = math.sqrt(size) * sampled.waveform(n)
        near(records[0], wave - wave.mean())
        return
    d, exact = np.diff(records), size * fourth(sampled.structure, np.arange(2.0))
    assert abs(np.mean(d**2) - exact[0]) < 0.15 * exact[0]
    assert abs(np.mean(d[:, 1:] * d[:, :-1]) - exact[1]) < 0.15 * exact[0]


CHECKS: tuple[Callable[[NoiseTerm], None], ...] = (asymptote, scaled, law, derivatives, sums, increments, oscillates,
                                                   spectra, transforms, waveforms, states)  # fmt: skip
"""What is demanded of a row at each of its shapes."""

RATES = (0.013, 0.047, 0.31, 2.1, 5.0)
"""Sampling rates, at which the times of a term are fractions of a sample to many samples."""

MODERATE = 0.31  # one at which a term is neither white nor a walk


@public
def check_term(row: NoiseTerm, *, expected_failed_checks: Mapping[str, str] = NONE) -> None:
    """Check that the columns of a row agree with its structure function D, at many rates, and its simulation, too.

    Raises
    ------
    AssertionError
        A column contradicts the others; the message says which, and where: ``noise term X: X: this does not hold:
        Each order by differences of the one below. ... (check 'derivatives')``

    Examples
    --------
    >>> from allanite import TERMS
    >>> check_term(TERMS["K"])
    """
    with checking(f"noise term {row.symbol}", expected_failed_checks) as check:
        for demanded in CHECKS:
            with check(demanded.__name__):
                for name, variant in sampled(row).items():
                    demand(demanded, variant, name)
        with check("simulated"):
            demand(simulated, *next((variant, name) for name, variant in sampled(row, (MODERATE,)).items()))


def sampled(row: NoiseTerm, rates: Sequence[float] = RATES) -> dict[str, NoiseTerm]:
    """A row, or those of its shapes, by name."""
    if row.shaped is None:
        return {row.symbol: row}
    typical = tuple(p.typical for p in row.parameters)
    # what is no time changes the form of the functions
    others = ((*typical[:i], value, *typical[i + 1 :]) for i, p in enumerate(row.parameters) if not p.time
              for value in (0.6, 1.5))  # fmt: skip
    return {f"{row.symbol} {shape} {rate:g}": row.shaped(shape, rate) for shape in (typical, *others) for rate in rates}


def demand(check: Callable[[NoiseTerm], None], row: NoiseTerm, name: str) -> None:
    """Raise what a check finds, and say which it is."""
    try:
        with np.errstate(all="ignore"):
            check(row)
    except Exception as error:
        what = " ".join((check.__doc__ or "").split())
        raise AssertionError(f"{name}: this does not hold: {what} {told(error)}") from error

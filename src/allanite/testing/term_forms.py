"""What is made of a row of `TERMS`: its waveform, its states in a filter and simulated records, against D."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.model import Term
from allanite.core.units import SIGNALS
from allanite.simulation.record import simulate
from allanite.terms import TERMS
from allanite.terms.row import Block, NoiseTerm

from .term_columns import NEAR, RATE, at, fourth, near, rounding, shaped


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
        found = (d @ C @ d.T)[:, 5]
        moment = fourth(other.structure, np.abs(np.arange(11.0) - 5))
        np.testing.assert_allclose(found, moment, rtol=1e-6, atol=rounding(other))
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


FORMS = waveforms, states

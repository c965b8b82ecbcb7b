"""Errors of the angle over an interval: RMS and maximum."""

import numpy as np

from allanite.phrases.phrase import say

from .row import FloatArray, IntArray, Statistic, binomial_window


def _first(x: FloatArray, m: IntArray) -> FloatArray:
    from allanite.kernels.overlapped import overlapped

    return overlapped(x, m, 1)


def _largest(x: FloatArray, m: IntArray) -> FloatArray:
    from allanite.kernels.extremes import largest_range

    return largest_range(x, m)  # type: ignore[no-any-return]


TIERMS = Statistic(
    name="tierms",
    synonyms=("rmstie",),
    title=say("TIE rms of the angle"),
    formula=r"\frac{1}{n+1-m} \sum_{i=0}^{n-m} (x_{i+m} - x_i)^2",
    reference="NIST SP 1065 section 5.2.19 (rms time interval error)",
    meaning="How far the angle moves within tau, RMS, in the unit of the angle, bias included.",
    use="The heading error that an uncorrected gyro accumulates within tau.",
    limits="A constant rate contributes fully: remove a known bias from the record first.",
    cost="About 0.2 ns per sample and tau; one copy of the record.",
    order=1,
    norm=lambda m: np.ones(np.shape(m)),
    span=(1, 0),
    sums=_first,
    pace=0.2,
    window=binomial_window(1),
    differences=1,
    power=1,
)

MTIE = Statistic(
    name="mtie",
    synonyms=("tie",),
    title=say("maximum time interval error (MTIE) of the angle"),
    formula=r"\max_i \bigl( \max_{i \le j \le i+m} x_j - \min_{i \le j \le i+m} x_j \bigr)^2",
    reference="ITU-T G.810; NIST SP 1065 section 5.2.18 (maximum time interval error)",
    meaning="The largest range of the angle within any window of tau, in the unit of the angle, bias included.",
    use="A bound for this record: the angle error over tau never exceeded it.",
    limits="A maximum: it grows with the length of the record and has no degrees of freedom; a single outlier "
    "determines it.",
    cost="15 ns per sample and tau; three copies of the record.",
    order=1,
    norm=lambda m: np.ones(np.shape(m)),
    span=(1, 0),
    sums=_largest,
    pace=15.0,
    window=None,
    power=1,
    extreme=True,
)

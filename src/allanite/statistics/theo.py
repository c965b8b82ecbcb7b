"""Theo1 and its hybrids, the parabolic deviation, and errors of the angle over an interval."""

from dataclasses import replace

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.kernels import allan, squared, summed
from allanite.phrases.phrase import say
from allanite.statistics.fast.theofft import split, theo1_sums
from allanite.statistics.moments.windowed import harmonic, theo_response, white_ratio

from .differences import OADEV
from .published import theo1
from .row import PublishedBias, Scheme, Sharp, Statistic, Window, binomial_window, constant


def _theo_window(m: int) -> Window:
    k = m // 2
    v = np.arange(1, k + 1)
    filters = np.zeros((k, m + 1))
    rows = np.arange(k)
    for column, sign in ((0 * v, 1), (v, -1), (m - v, -1), (0 * v + m, 1)):
        filters[rows, column] += sign
    return 1 / v, filters


def _ramp(m: int) -> FloatArray:
    j = np.arange(m + 1)
    g = -np.maximum(j, m - j).astype(np.float64)
    g[m // 2] *= 2
    g[0] = g[m] = 0.0
    g[0] = g[m] = -g.sum() / 2
    return g


KEPT_AT = (0.06, 0.2, 0.39, 0.78, 1.0)
KEPT = {-0.5: (0.45, 0.47, 0.70, 0.91, 0.97), 0.0: (0.66, 0.66, 0.80, 0.92, 0.94), 0.5: (0.72, 0.74, 0.79, 0.88, 0.89)}
"""EDF of TheoBR over that of Theo1 at m over the record's length, by the slope of the noise's Allan deviation: its bias
ratio scatters too (simulated: benchmarks/moments.py)."""


def _kept(slope: float, share: float) -> float:
    """What is known of the next lower slope; the least of all where there is none."""
    row = KEPT[max((known for known in KEPT if known <= slope), default=min(KEPT))]
    return float(np.interp(share, KEPT_AT, row))


THEO1 = Statistic(
    name="theo1", synonyms=("theo",), title=say("Theo1 deviation"),
    formula=r"\frac{1}{0.75 (n+1-m) (m\tau_0)^2} \sum_{i=0}^{n-m} \sum_{d=0}^{m/2-1} \frac{1}{m/2-d} "
    r"\bigl[ (x_i - x_{i-d+m/2}) + (x_{i+m} - x_{i+d+m/2}) \bigr]^2, \quad \tau = 0.75\,m\,\tau_0",
    reference="D. A. Howe & T. K. Peppler, 2003; D. A. Howe & T. N. Tasset, EFTF 2004; NIST SP 1065 eq. 30 "
    "(which omits the 0.75)",
    meaning="The Allan deviation at three quarters of the window, from all pairs of differences within it.",
    use="Long tau: it extends to 0.75 of the record, with up to three times the degrees of freedom of oadev.",
    limits="Unbiased for white rate noise only; for flicker, random walk and ramp the variance is low by factors of "
    "1.9, 2.7 and 3.7, for quantization it is high. m is even; published use begins at m = 10.",
    cost="For a few tau 0.16 ns n m / 2 each; for many 0.25 us m each, or all even m up to the largest in 0.2 ns "
    "times its square; ten copies of the record.",
    order=2, norm=constant(0.75), span=(1, 0), sums=theo1_sums, split=split, pace=0.8, window=_theo_window,
    target="oadev", step=2, tau_factor=0.75,
    scheme=Scheme(
        levels=(16, 32, 64), power=1, sharp=Sharp(levels=(16, 32, 64), scale=harmonic, itself=white_ratio),
        response=theo_response, leading=16, ramp=_ramp,
    ),
    published=PublishedBias(
        reference="D. A. Howe & T. N. Tasset, EFTF 2004; NIST SP 1065 section 5.2.15: AVAR = Theo1 (a + b/t^c), "
        "t = 0.75 m", limits="m of 10 or more",
        factor=lambda c, m, size: np.asarray(1 / (c[0] + c[1] / (0.75 * m) ** c[2])),
        coefficients={
            2: (0.09, 0.74, 0.40),
            1: (0.14, 0.82, 0.30),
            0: (1.00, 0.00, 0.00),
            -1: (1.87, -1.05, 0.79),
            -2: (2.70, -1.53, 0.85),
        },
    ),
    published_edf=theo1,
)  # fmt: skip

THEOBR = replace(
    THEO1, name="theobr", synonyms=(), title=say("TheoBR deviation (Theo1, bias removed)"),
    formula=r"k_f\,\mathrm{Theo1}(\tau), \quad k_f = \frac{1}{p+1} \sum_{i=0}^{p} "
    r"\frac{\mathrm{OAVAR}(m = 9+3i)}{\mathrm{Theo1}(m = 12+4i)}, \quad p = \lfloor (n+1)/30 - 3 \rfloor",
    reference="D. A. Howe, Metrologia 43, 2006; J. A. Taylor & D. A. Howe, 2010",
    meaning="Theo1 scaled to the Allan variance by one ratio, taken at averaging times where both are known well.",
    use="As Theo1, to be read like an Allan deviation, if one kind of noise dominates the whole record.",
    limits="The ratio is that of tau below a tenth of the record: if the kind of noise changes beyond, the deviation "
    "is wrong by up to a factor of 1.5. bias='model' corrects it with the model.",
    cost="That of theo1, and once that of every even m up to 2/15 of the record: 4 ps n^2.",
    parts=(THEO1,), kept=_kept, published=None,
)  # fmt: skip

THEOH = replace(
    THEOBR,
    name="theoh",
    synonyms=(),
    title=say("TheoH deviation (oadev, then TheoBR)"),
    formula=r"\mathrm{OAVAR}(\tau) \text{ for } \tau \le 0.2\,T, \quad \mathrm{TheoBR}(\tau) \text{ beyond}",
    reference="J. A. Taylor & D. A. Howe, 2010; NIST SP 1065 section 5.2.16",
    meaning="One curve from the sample interval to three quarters of the record.",
    use="The whole range in one curve, as in the literature on fiber and laser gyros.",
    limits="Those of theobr beyond the joint.",
    parts=(OADEV, THEO1),
    step=1,
)


def _parabolic_window(m: int) -> Window:
    if m == 1:
        return binomial_window(2)(1)
    slope = (m - 1) / 2 - np.arange(m)
    return np.ones(1), np.concatenate((slope, -slope))[None, :]


PDEV = Statistic(
    name="pdev", synonyms=("pvar", "parabolic"), title=say("parabolic deviation"),
    formula=r"\frac{72}{m^4 \tau^2 (n+1-2m)} \sum_{i=0}^{n-2m} \Bigl[ \sum_{k=0}^{m-1} \bigl(\tfrac{m-1}{2} - k\bigr) "
    r"(x_{i+k} - x_{i+m+k}) \Bigr]^2 \quad (m = 1: \mathrm{OAVAR})",
    reference="F. Vernotte, M. Lenczner, P.-Y. Bourgeois & E. Rubiola, IEEE UFFC 63, 2016; F. Vernotte et al., 2020",
    meaning="The Allan deviation with rates from least-squares slopes of the angle instead of its differences.",
    use="Fast angle noise (quantization): it is suppressed as in mdev, over windows of 2 tau instead of 3.",
    limits="White rate noise gives 6/5 of its Allan variance, other noise other ratios.",
    cost="About 4 ns per sample and tau; a copy of the record and segments of 16 tau.", order=2,
    norm=lambda m: np.where(m == 1, 2.0, np.asarray(m, dtype=np.float64) ** 4 / 72),
    span=(2, 0), sums=lambda x, m: np.where(m == 1, squared.overlapped(x, m, 2), summed.parabolic(x, m)),
    pace=4.0, window=_parabolic_window, scheme=Scheme(leading=12),
)  # fmt: skip


TIERMS = Statistic(
    name="tierms", synonyms=("rmstie",), title=say("TIE rms of the angle"),
    formula=r"\frac{1}{n+1-m} \sum_{i=0}^{n-m} (x_{i+m} - x_i)^2",
    reference="NIST SP 1065 section 5.2.19 (rms time interval error)",
    meaning="How far the angle moves within tau, RMS, in the unit of the angle, bias included.",
    use="The heading error that an uncorrected gyro accumulates within tau.",
    limits="A constant rate contributes fully: remove a known bias from the record first.",
    cost="About 0.2 ns per sample and tau; one copy of the record.", order=1, norm=lambda m: np.ones(np.shape(m)),
    span=(1, 0), sums=lambda x, m: squared.overlapped(x, m, 1), pace=0.2, window=binomial_window(1), differences=1,
    power=1,
)  # fmt: skip

MTIE = Statistic(
    name="mtie", synonyms=("tie",), title=say("maximum time interval error (MTIE) of the angle"),
    formula=r"\max_i \bigl( \max_{i \le j \le i+m} x_j - \min_{i \le j \le i+m} x_j \bigr)^2",
    reference="ITU-T G.810; NIST SP 1065 section 5.2.18 (maximum time interval error)",
    meaning="The largest range of the angle within any window of tau, in the unit of the angle, bias included.",
    use="A bound for this record: the angle error over tau never exceeded it.",
    limits="A maximum: it grows with the length of the record and has no degrees of freedom; a single outlier "
    "determines it.", cost="15 ns per sample and tau; three copies of the record.", order=1,
    norm=lambda m: np.ones(np.shape(m)), span=(1, 0), sums=lambda x, m: np.asarray(allan.largest_range(x, m)),
    pace=15.0, window=None, power=1, extreme=True,
)  # fmt: skip

"""Total statistics: the record, or each window, is extended by reflection, so that long tau keep more terms."""

from dataclasses import replace

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.kernels import allan, squared, total
from allanite.phrases.phrase import say

from . import published
from .row import PublishedBias, Scheme, Sharp, Statistic, Window, constant


def _hadamard_total(x: FloatArray, m: IntArray) -> FloatArray:
    sums = total.modified_total(np.diff(x), m)
    # SP 1065: at m = 1 the overlapping Hadamard form, which has as many windows
    return np.where(m == 1, squared.overlapped(x, m, 3), sums)


def folding(m: int) -> FloatArray:
    """Differences of means of the detrended, folded window of 3m points, shape (6m, 3m)."""
    detrended = np.eye(3 * m) - np.outer(np.arange(3 * m), _slope(3 * m))
    return _differences(np.concatenate((detrended[::-1], detrended, detrended[::-1])), m)[: 6 * m]


def _slope(points: int) -> FloatArray:
    """Weights of the points in the slope between the means of both halves."""
    half = points // 2
    mean = np.zeros(points)
    mean[-half:] += 1 / half
    mean[:half] -= 1 / half
    return mean / (points - half)


def _differences(x: FloatArray, m: int) -> FloatArray:
    """Second differences of means of m, along the first axis."""
    means = np.cumsum(np.concatenate((np.zeros((1, *x.shape[1:])), x)), axis=0)
    means = (means[m:] - means[:-m]) / m
    return np.asarray(means[2 * m :] - 2 * means[m:-m] + means[: -2 * m])


def _ramp(m: int) -> FloatArray:
    """Half the gradient of the sum of squares at the ramp: each step of `folding` forward, then its transpose."""
    place = np.arange(3 * m) - (3 * m - 1) / 2
    x = place**2 / 2
    places = _differences(np.concatenate((x[::-1], x, x[::-1])), m)[: 6 * m]
    folded = _differences(np.pad(places, (3 * m - 1, 3 * m)), m)[: 9 * m] / (6 * m)
    g = folded[: 3 * m][::-1] + folded[3 * m : 6 * m] + folded[6 * m :][::-1]
    return np.asarray(g - place @ g * _slope(3 * m))


def _rate_window(m: int) -> Window:
    if m == 1:
        return np.ones(1), np.array([[-1.0, 3.0, -3.0, 1.0]])
    filters = folding(m)
    edge = np.zeros((6 * m, 1))
    return np.full(6 * m, 1 / (6 * m)), np.hstack((edge, filters)) - np.hstack((filters, edge))


TOTDEV = Statistic(
    name="totdev", synonyms=("totvar", "total"), title=say("total deviation"),
    formula=r"\frac{1}{2\tau^2 (n-1)} \sum_{i=1}^{n-1} (x^*_{i-m} - 2x^*_i + x^*_{i+m})^2, \quad "
    r"x^*_{-j} = 2x_0 - x_j, \quad x^*_{n+j} = 2x_n - x_{n-j}",
    reference="D. A. Howe, 1995; C. A. Greenhall, D. A. Howe & D. B. Percival, IEEE UFFC 46, 1999; NIST SP 1065 eq. 25",
    meaning="The Allan deviation of the record extended by reflection at both ends.",
    use="Long tau of short records, up to the whole length: the last points scatter less than those of oadev.",
    limits="Biased at long tau: low by up to a quarter (flicker) or 3/8 (random walk) of the variance at half the "
    "record, high by two thirds for quantization, which published tables omit. Not defined for a record with "
    "gaps.", cost="About 0.3 ns per sample and tau; two copies of the record.",
    order=2, norm=constant(2.0), span=(0, 2), sums=lambda x, m: np.asarray(allan.folded(x, m)), pace=0.4,
    window=None, target="oadev", gaps=False,
    published=PublishedBias(
        reference="C. A. Greenhall, D. A. Howe & D. B. Percival, IEEE UFFC 46, 1999; NIST SP 1065 section 5.2.11",
        limits="tau up to half the record; not for angle noise, whose variance is high by 1.34 tau/T",
        factor=lambda c, m, size: np.asarray(1 - c[0] * m / size), coefficients={0: (0.0,), -1: (0.481,), -2: (0.75,)},
    ),
    published_edf=published.total,
)  # fmt: skip

MTOTDEV = Statistic(
    name="mtotdev", synonyms=("mtotvar",), title=say("modified total deviation"),
    formula=r"\frac{1}{2\tau^2 (n+2-3m)} \sum_{k=0}^{n+1-3m} \frac{1}{6m} \sum_{j=0}^{6m-1} "
    r"(\bar e_{j+2m} - 2 \bar e_{j+m} + \bar e_j)^2, \quad e: \text{window of } 3m \text{ points less its half-mean "
    r"slope, folded back at both ends}", reference="C. A. Greenhall & D. A. Howe, FCS 1999; NIST SP 1065 eq. 27",
    meaning="The modified Allan deviation with every window extended by reflection, so that all its points are used.",
    use="As mdev, if the record is short.",
    limits="Biased low: by 0 to 32 % of the variance, depending on the noise (the factor is known exactly); by half at "
    "m = 1.",
    cost="30 ns per sample and tau, independent of m: running sums replace the 6m terms of a window; a copy of the "
    "record.", order=2, norm=constant(2.0), span=(3, -1), sums=lambda x, m: np.asarray(total.modified_total(x, m)),
    pace=40.0, window=lambda m: (np.full(6 * m, 1 / (6 * m)), folding(m)), target="mdev",
    published=PublishedBias(
        reference="D. A. Howe & F. Vernotte, PTTI 1999; NIST SP 1065 section 5.2.12",
        limits="one number for every m: at m = 1 the statistic is half its target for any noise, and beyond m = 8 the "
        "published factors are 2 to 6 % low (high by 2 % for random walk)",
        factor=lambda c, m, size: np.full(m.shape, c[0]),
        coefficients={2: (0.94,), 1: (0.83,), 0: (0.73,), -1: (0.70,), -2: (0.69,)},
    ),
    scheme=Scheme(ramp=_ramp), published_edf=published.modified_total,
)  # fmt: skip

TTOTDEV = replace(
    MTOTDEV, name="ttotdev", synonyms=("ttotvar",), title=say("time total deviation (TTOTDEV) of the angle"),
    formula=r"\frac{\tau^2}{3}\,\mathrm{MTOT}(\tau)", reference="NIST SP 1065 eq. 28 (which prints tau^3: a misprint)",
    meaning="The time deviation with every window extended by reflection.", use="As tdev, if the record is short.",
    norm=constant(6.0), target="tdev", power=1,
)  # fmt: skip

HTOTDEV = replace(
    MTOTDEV, name="htotdev", synonyms=("htotvar",), title=say("Hadamard total deviation"),
    formula=r"\frac{1}{6 (n+1-3m)} \sum_{k=0}^{n-3m} \frac{1}{6m} \sum_{j=0}^{6m-1} "
    r"(\bar e_{j+2m} - 2 \bar e_{j+m} + \bar e_j)^2, \quad e: \text{as in mtotdev, of the rate}",
    reference="D. A. Howe et al., FCS 2000; NIST SP 1065 eq. 29",
    meaning="The Hadamard deviation with every window extended by reflection.",
    use="Drift and random walk at long tau of short records.",
    limits="Biased low by 0 to 32 % of the variance, depending on the noise (the factor is known exactly). Equal to "
    "ohdev at m = 1.", order=3, norm=lambda m: 6.0 / np.asarray(m, dtype=np.float64) ** 2,
    span=(3, 0), sums=_hadamard_total, window=_rate_window, target="ohdev",
    scheme=Scheme(sharp=Sharp(levels=(10, 20, 40), scale=lambda m: 1.0)),
    published=PublishedBias(
        reference="D. A. Howe et al., PTTI 2000; NIST SP 1065 section 5.2.14",
        limits="not for angle noise; m = 1 is the overlapping Hadamard variance, without bias",
        factor=lambda c, m, size: np.where(m > 1, c[0], 1.0),
        coefficients={0: (0.995,), -1: (0.851,), -2: (0.771,), -3: (0.717,), -4: (0.679,)},
    ),
    published_edf=published.hadamard_total,
)  # fmt: skip

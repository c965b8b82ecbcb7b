"""Second differences of the angle averaged over m points: the modified Allan deviation and the time deviation."""

from dataclasses import replace

import numpy as np

from allanite.statistics.fast.everytau import dense, split

from .row import FloatArray, IntArray, Statistic, Window


def _modified(x: FloatArray, m: IntArray) -> FloatArray:
    from allanite.kernels.summed import modified

    return dense(x, m, 3, summed=True, direct=modified)


def _window(m: int) -> Window:
    return np.ones(1), np.repeat([1.0, -2.0, 1.0], m)[None, :]


MDEV = Statistic(
    name="mdev",
    title="modified Allan deviation",
    formula=r"\frac{1}{2\tau^2 m^2 (n+2-3m)} \sum_{j=0}^{n+1-3m} \Bigl[ \sum_{i=j}^{j+m-1} "
    r"(x_{i+2m} - 2x_{i+m} + x_i) \Bigr]^2",
    reference="D. W. Allan & J. A. Barnes, 1981; NIST SP 1065 eq. 14",
    meaning="The Allan deviation of an angle smoothed over tau: fast noise is averaged away, slow noise is not.",
    use="To tell kinds of fast noise apart: quantization falls with slope -3/2 here and flicker of the angle with -1, "
    "while both fall with -1 in oadev.",
    limits="White rate noise reads half its Allan variance, other noise other shares: no coefficient is read off.",
    cost="2.6 units of 0.16 ns for each sample and tau; one copy of the record and segments of 64 tau. Every tau by "
    "transforms: 1.5 us for each sample.",
    order=2,
    norm=lambda m: 2.0 * np.asarray(m, dtype=np.float64) ** 2,
    span=(3, -1),
    sums=_modified,
    split=split(3, summed=True),
    window=_window,
    differences=3,
    summed=True,
)

TDEV = replace(
    MDEV,
    name="tdev",
    title="time deviation of the angle",
    formula=r"\frac{\tau^2}{3}\,\mathrm{MVAR}(\tau)",
    reference="NIST SP 1065 eq. 15",
    meaning="The error of the angle that builds up over tau, in the unit of the angle.",
    use="Where the angle matters and not the rate: pointing, dead reckoning between fixes.",
    norm=lambda m: 6.0 * np.asarray(m, dtype=np.float64) ** 2,
    power=1,
)

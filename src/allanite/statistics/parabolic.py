"""The parabolic deviation: differences of slopes fitted to the angle by least squares."""

import numpy as np

from allanite.phrases.phrase import say

from .row import FloatArray, IntArray, Scheme, Statistic, Window, binomial_window


def _parabolic(x: FloatArray, m: IntArray) -> FloatArray:
    from allanite.kernels.overlapped import overlapped
    from allanite.kernels.summed import parabolic

    return np.asarray(np.where(m == 1, overlapped(x, m, 2), parabolic(x, m)))


def _window(m: int) -> Window:
    if m == 1:
        return binomial_window(2)(1)
    slope = (m - 1) / 2 - np.arange(m)
    return np.ones(1), np.concatenate((slope, -slope))[None, :]


PDEV = Statistic(
    name="pdev",
    synonyms=("pvar", "parabolic"),
    title=say("parabolic deviation"),
    formula=r"\frac{72}{m^4 \tau^2 (n+1-2m)} \sum_{i=0}^{n-2m} \Bigl[ \sum_{k=0}^{m-1} \bigl(\tfrac{m-1}{2} - k\bigr) "
    r"(x_{i+k} - x_{i+m+k}) \Bigr]^2 \quad (m = 1: \mathrm{OAVAR})",
    reference="F. Vernotte, M. Lenczner, P.-Y. Bourgeois & E. Rubiola, IEEE UFFC 63, 2016; F. Vernotte et al., 2020",
    meaning="The Allan deviation with rates from least-squares slopes of the angle instead of its differences.",
    use="Fast angle noise (quantization): it is suppressed as in mdev, over windows of 2 tau instead of 3.",
    limits="White rate noise gives 6/5 of its Allan variance, other noise other ratios.",
    cost="About 4 ns per sample and tau; a copy of the record and segments of 16 tau.",
    order=2,
    norm=lambda m: np.where(m == 1, 2.0, np.asarray(m, dtype=np.float64) ** 4 / 72),
    span=(2, 0),
    sums=_parabolic,
    pace=4.0,
    window=_window,
    scheme=Scheme(leading=12),
)

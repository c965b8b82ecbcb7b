"""The Haar wavelet variance of the rate, by the pyramid of the maximal overlap transform."""

from tests.reference.terms import mean, rate, require


def haar(x, m, tau0):
    """Mean square of the level-j coefficients that no boundary touches; m = 2^(j-1) is the scale.

    w_{j,t} = (v_{j-1,t} - v_{j-1,t-m})/2, v_{j,t} = (v_{j-1,t} + v_{j-1,t-m})/2, v_0 = y.
    D. B. Percival, A. T. Walden, Wavelet Methods for Time Series Analysis, 2000, 5.4 and 8.3.
    """
    require(m & (m - 1) == 0, "m is a power of two")
    v, scale = rate(x, tau0), 1
    while scale < m:
        v, scale = (v[scale:] + v[:-scale]) / 2, 2 * scale
    require(len(v) > m, "no coefficient without a boundary")
    return mean(((v[m:] - v[:-m]) / 2) ** 2)

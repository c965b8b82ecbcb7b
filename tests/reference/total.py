"""The total variances from the phase x_0 .. x_N: raw, without any factor for their bias."""

import numpy as np

from tests.reference.hadamard import ohdev
from tests.reference.modified import mean_second_differences
from tests.reference.terms import indices, mean, rate, require


def totdev(x, m, tau0):
    """Second differences centred on the inner points of x, continued by reflection about both ends, 1 <= m <= N.

    x*_{-j} = 2 x_0 - x_j and x*_{N+j} = 2 x_N - x_{N-j} for j = 1 .. N-1;
    1/(2 tau^2 (N-1)) sum_{i=1}^{N-1} (x*_{i-m} - 2 x*_i + x*_{i+m})^2.
    C. A. Greenhall, D. A. Howe, D. B. Percival, IEEE Trans. UFFC 46, 1999; NIST SP 1065 eq. 25.
    """
    last = len(x) - 1
    require(m <= last, "the continuation ends at N - 1 points beyond the ends")

    j = np.arange(last - 1, 0, -1)
    star = np.concatenate((2 * x[0] - x[j], x, 2 * x[last] - x[j]))
    i = last - 1 + np.arange(1, last)
    squares = (star[i - m] - 2 * star[i] + star[i + m]) ** 2
    return mean(squares) / (2 * (m * tau0) ** 2)


def _mean_square_of_reflected(s, m):
    """The mean of 6m squared second differences of m-point means of the detrended and mirrored window s of 3m points.

    Steps 1 to 4 of D. A. Howe, F. Vernotte, PTTI 1999: the slope from the means of the two halves (the middle point of
    an odd window left out); even mirror images at both sides; second differences of means at stride m.
    """
    half = 3 * m // 2
    slope = (mean(s[-half:]) - mean(s[:half])) / (3 * m - half)
    s = s - slope * np.arange(3 * m)
    e = np.concatenate((s[::-1], s, s[::-1]))
    return mean(mean_second_differences(e, m)[: 6 * m] ** 2)


def mtotdev(x, m, tau0):
    """1/(2 tau^2) mean_n of the mirrored windows x_n .. x_{n+3m-1}, n = 0 .. N - 3m + 1. NIST SP 1065 eq. 27."""
    windows = [x[n : n + 3 * m] for n in indices(len(x) - 3 * m + 1)]
    return mean([_mean_square_of_reflected(s, m) for s in windows]) / (2 * (m * tau0) ** 2)


def ttotdev(x, m, tau0):
    """tau^2/3 times the modified total variance. NIST SP 1065 eq. 28, whose tau^3 is a misprint."""
    return (m * tau0) ** 2 * mtotdev(x, m, tau0) / 3


def htotdev(x, m, tau0):
    """1/6 mean_n of the mirrored windows y_n .. y_{n+3m-1} of the rate; the overlapped Hadamard variance at m = 1.

    D. A. Howe et al., PTTI 2000; NIST SP 1065 eq. 29 and its table 31, where m = 1 is OHDEV.
    """
    if m == 1:
        return ohdev(x, m, tau0)
    y = rate(x, tau0)
    windows = [y[n : n + 3 * m] for n in indices(len(y) - 3 * m + 1)]
    return mean([_mean_square_of_reflected(s, m) for s in windows]) / 6

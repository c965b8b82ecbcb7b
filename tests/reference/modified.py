"""The modified Allan variance and the time variance from the phase x_0 .. x_N."""

from tests.reference.terms import indices, mean


def mean_second_differences(x, m):
    """1/m sum_{k=i}^{i+m-1} (x_{k+2m} - 2 x_{k+m} + x_k) for every i that has all its points."""
    k = indices(len(x) - 2 * m)
    d = x[k + 2 * m] - 2 * x[k + m] + x[k]
    count = max(len(x) - 3 * m + 1, 0)
    return sum(d[k : k + count] for k in range(m)) / m


def mdev(x, m, tau0):
    """1/(2 tau^2) mean_i [1/m sum_{k=i}^{i+m-1} (x_{k+2m} - 2 x_{k+m} + x_k)]^2, N - 3m + 2 terms. SP 1065 eq. 14."""
    return mean(mean_second_differences(x, m) ** 2) / (2 * (m * tau0) ** 2)


def tdev(x, m, tau0):
    """Time variance, tau^2/3 times the modified Allan variance. NIST SP 1065 eq. 15."""
    return (m * tau0) ** 2 * mdev(x, m, tau0) / 3

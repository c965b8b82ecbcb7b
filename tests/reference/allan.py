"""The Allan variance from the phase x_0 .. x_N, as NIST SP 1065 and IEEE Std 952 print it."""

from tests.reference.terms import indices, mean, phase


def adev(x, m, tau0):
    """Every m-th point: 1/(2 tau^2) mean_j (x_{(j+2)m} - 2 x_{(j+1)m} + x_{jm})^2. NIST SP 1065 eq. 7."""
    x = x[::m]
    j = indices(len(x) - 2)
    return mean((x[j + 2] - 2 * x[j + 1] + x[j]) ** 2) / (2 * (m * tau0) ** 2)


def oadev(x, m, tau0):
    """1/(2 tau^2) mean_i (x_{i+2m} - 2 x_{i+m} + x_i)^2 over all i. NIST SP 1065 eq. 11."""
    i = indices(len(x) - 2 * m)
    return mean((x[i + 2 * m] - 2 * x[i + m] + x[i]) ** 2) / (2 * (m * tau0) ** 2)


def _of_rate(referee):
    """The same referee for a list of rates."""
    return lambda y, m, tau0=1: referee(phase(y, tau0), m, tau0)


REFEREES = {"adev": _of_rate(adev), "oadev": _of_rate(oadev)}

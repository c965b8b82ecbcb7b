"""The Hadamard variance from the phase x_0 .. x_N."""

from tests.reference.terms import indices, mean


def hdev(x, m, tau0):
    """Every m-th point: 1/(6 tau^2) mean_j (third difference)^2. NIST SP 1065 eq. 18."""
    x = x[::m]
    j = indices(len(x) - 3)
    return mean((x[j + 3] - 3 * x[j + 2] + 3 * x[j + 1] - x[j]) ** 2) / (6 * (m * tau0) ** 2)


def ohdev(x, m, tau0):
    """1/(6 tau^2) mean_i (x_{i+3m} - 3 x_{i+2m} + 3 x_{i+m} - x_i)^2 over all i. NIST SP 1065 eq. 20."""
    i = indices(len(x) - 3 * m)
    return mean((x[i + 3 * m] - 3 * x[i + 2 * m] + 3 * x[i + m] - x[i]) ** 2) / (6 * (m * tau0) ** 2)

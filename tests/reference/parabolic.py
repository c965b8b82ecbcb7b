"""The parabolic variance from the phase x_0 .. x_N."""

from tests.reference.allan import oadev
from tests.reference.terms import indices, mean


def pdev(x, m, tau0):
    """72/(m^4 tau^2) mean_i [sum_{k=0}^{m-1} ((m-1)/2 - k) (x_{i+k} - x_{i+m+k})]^2, i = 0 .. N - 2m; Allan at m = 1.

    F. Vernotte, M. Lenczner, P.-Y. Bourgeois, E. Rubiola, IEEE Trans. UFFC 63, 2016; the number of terms is that of
    F. Vernotte's SigmaTheta, one less than fit into the record.
    """
    if m == 1:
        return oadev(x, m, tau0)
    i = indices(len(x) - 2 * m)
    inner = sum((x[i + k] - x[i + m + k]) * (m - 1 - 2 * k) for k in range(m)) / 2
    return 72 * mean(inner**2) / (m**4 * (m * tau0) ** 2)

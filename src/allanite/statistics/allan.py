"""The Allan variance, with and without overlapping."""

from .row import FloatArray, IntArray, Statistic


def _overlapped(x: FloatArray, m: IntArray) -> FloatArray:
    from allanite.kernels.allan import overlapped

    return overlapped(x, m)  # type: ignore[no-any-return]


def _strided(x: FloatArray, m: IntArray) -> FloatArray:
    from allanite.kernels.allan import strided

    return strided(x, m)  # type: ignore[no-any-return]


ADEV = Statistic(
    name="adev",
    title="Allan deviation",
    formula=r"\frac{1}{2\tau^2 (J-2)} \sum_{j=0}^{J-3} (x_{(j+2)m} - 2x_{(j+1)m} + x_{jm})^2,"
    r"\quad J = \lfloor n/m \rfloor + 1",
    reference="D. W. Allan, Proc. IEEE 54, 1966; NIST SP 1065 eq. 8; IEEE Std 952",
    order=2,
    norm=2.0,
    overlapped=False,
    largest=lambda n: n // 2,
    count=lambda n, m: n // m - 1,
    sums=_strided,
)

OADEV = Statistic(
    name="oadev",
    title="overlapped Allan deviation",
    formula=r"\frac{1}{2\tau^2 (n+1-2m)} \sum_{i=0}^{n-2m} (x_{i+2m} - 2x_{i+m} + x_i)^2",
    reference="NIST SP 1065 eq. 11; IEEE Std 952",
    order=2,
    norm=2.0,
    overlapped=True,
    largest=lambda n: n // 2,
    count=lambda n, m: n + 1 - 2 * m,
    sums=_overlapped,
)

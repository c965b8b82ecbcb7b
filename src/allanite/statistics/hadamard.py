"""Third differences of the angle: the Hadamard deviation, blind to a rate ramp."""

from dataclasses import replace

from allanite.statistics.fast.everytau import dense, split

from .row import FloatArray, IntArray, Statistic, binomial_window, constant, interleaved


def _third(x: FloatArray, m: IntArray) -> FloatArray:
    from allanite.kernels.allan import third

    return dense(x, m, 3, direct=third)


def _strided(x: FloatArray, m: IntArray) -> FloatArray:
    from allanite.kernels.allan import strided_third

    return strided_third(x, m)  # type: ignore[no-any-return]


OHDEV = Statistic(
    name="ohdev",
    title="overlapped Hadamard deviation",
    formula=r"\frac{1}{6\tau^2 (n+1-3m)} \sum_{i=0}^{n-3m} (x_{i+3m} - 3x_{i+2m} + 3x_{i+m} - x_i)^2",
    reference="NIST SP 1065 eq. 18; R. A. Baugh, 1971",
    meaning="Like the Allan deviation of the rate's change: a steady ramp of the rate drops out.",
    use="Beside oadev, to tell a deterministic drift from rate random walk: only the drift is missing here.",
    limits="Below oadev at long tau even without a ramp: by 0.71 for rate random walk, 0.90 for flicker. "
    "Only a ratio below 0.71 needs a ramp.",
    cost="1.7 units of 0.16 ns for each sample and tau; one copy of the record. Every tau by transforms: "
    "1 us for each sample, six copies.",
    order=3,
    norm=constant(6.0),
    span=(3, 0),
    sums=_third,
    split=split(3),
    window=binomial_window(3),
    differences=3,
)

HDEV = replace(
    OHDEV,
    name="hdev",
    title="Hadamard deviation",
    formula=r"\frac{1}{6\tau^2 (J-3)} \sum_{j=0}^{J-4} (x_{(j+3)m} - 3x_{(j+2)m} + 3x_{(j+1)m} - x_{jm})^2,"
    r"\quad J = \lfloor n/m \rfloor + 1",
    reference="NIST SP 1065 eq. 17; R. A. Baugh, 1971",
    use="To repeat older results; otherwise the overlapped form is better at the same price.",
    limits="Uses every window once only; otherwise as ohdev.",
    cost="Less than ohdev: n/m terms for each tau; one copy of the record.",
    overlapped=False,
    sums=_strided,
    split=interleaved,
)

"""Second differences of the angle: the Allan deviation and its Haar relative."""

from dataclasses import replace

from allanite.statistics.fast.everytau import dense, split

from .row import FloatArray, IntArray, Statistic, binomial_window, constant, interleaved


def _second(x: FloatArray, m: IntArray) -> FloatArray:
    from allanite.kernels.allan import second

    return dense(x, m, 2, direct=second)


def _strided(x: FloatArray, m: IntArray) -> FloatArray:
    from allanite.kernels.allan import strided_second

    return strided_second(x, m)  # type: ignore[no-any-return]


OADEV = Statistic(
    name="oadev",
    title="overlapped Allan deviation",
    formula=r"\frac{1}{2\tau^2 (n+1-2m)} \sum_{i=0}^{n-2m} (x_{i+2m} - 2x_{i+m} + x_i)^2",
    reference="NIST SP 1065 eq. 11; IEEE Std 952",
    meaning="How much the mean rate over tau changes from one interval to the next.",
    use="The default: every noise term of IEEE Std 952 has its own slope, and the overlap uses all of the record.",
    limits="A ramp hides what is slower than it; quantization and fast noise beyond white have nearly the same slope.",
    cost="1.3 units of 0.16 ns for each sample and tau; one copy of the record. Every tau by transforms: "
    "0.5 us for each sample, six copies.",
    order=2,
    norm=constant(2.0),
    span=(2, 0),
    sums=_second,
    split=split(2),
    window=binomial_window(2),
    differences=2,
)

ADEV = replace(
    OADEV,
    name="adev",
    title="Allan deviation",
    formula=r"\frac{1}{2\tau^2 (J-2)} \sum_{j=0}^{J-3} (x_{(j+2)m} - 2x_{(j+1)m} + x_{jm})^2,"
    r"\quad J = \lfloor n/m \rfloor + 1",
    reference="D. W. Allan, Proc. IEEE 54, 1966; NIST SP 1065 eq. 8; IEEE Std 952",
    use="To repeat what a data sheet or an older paper did; otherwise the overlapped form is better at the same price.",
    limits="Uses every window once only: at long tau its intervals are up to twice as wide as those of oadev.",
    cost="Less than oadev: n/m terms for each tau; one copy of the record.",
    overlapped=False,
    sums=_strided,
    split=interleaved,
)

HAAR = replace(
    OADEV,
    name="haar",
    title="Haar wavelet (MODWT) deviation",
    formula=r"\nu^2(\tau) = \tfrac12\,\mathrm{OAVAR}(\tau), \quad \tau = 2^{j-1} \tau_0 \text{ at level } j",
    reference="D. B. Percival & A. T. Walden, Wavelet Methods for Time Series Analysis, 2000, section 8.6",
    meaning="The wavelet variance of the Haar filter: the rate's variance split up by time scale.",
    use="To compare with wavelet tools (wv, gmwm): it is exactly half the overlapped Allan variance.",
    limits="Those of oadev. The dyadic scales of the transform are the octave grid; other factors continue it.",
    norm=constant(4.0),
)

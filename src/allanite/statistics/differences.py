"""Differences of the angle: second (Allan, Haar), third (Hadamard), and second of means over m points (modified)."""

from dataclasses import replace
from functools import partial

import numpy as np

from allanite.kernels import allan
from allanite.phrases.phrase import say
from allanite.statistics.fast.everytau import dense, split

from .published import greenhall_riley
from .row import Statistic, binomial_window, constant, interleaved

OADEV = Statistic(
    name="oadev", synonyms=("avar", "oavar", "allan", "allan_deviation", "allan_variance"),
    title=say("overlapping Allan deviation"),
    formula=r"\frac{1}{2\tau^2 (n+1-2m)} \sum_{i=0}^{n-2m} (x_{i+2m} - 2x_{i+m} + x_i)^2",
    reference="NIST SP 1065 eq. 11; IEEE Std 952",
    meaning="The typical change of the mean rate over tau from one interval to the next.",
    use="The default: every noise term of IEEE Std 952 has its own slope, and the overlapping windows use the whole "
    "record.",
    limits="A ramp hides slower noise; quantization and fast noise other than white have nearly the same slope.",
    cost="About 0.2 ns per sample and tau; one copy of the record. All tau together by FFT: 0.5 us per sample, six "
    "copies.", order=2, norm=constant(2.0), span=(2, 0), sums=partial(dense, order=2),
    split=partial(split, order=2), window=binomial_window(2), differences=2,
    published_edf=partial(greenhall_riley, d=2),
)  # fmt: skip

ADEV = replace(
    OADEV, name="adev", synonyms=("nonoverlapping", "classic"), title=say("Allan deviation"),
    formula=r"\frac{1}{2\tau^2 (J-2)} \sum_{j=0}^{J-3} (x_{(j+2)m} - 2x_{(j+1)m} + x_{jm})^2,"
    r"\quad J = \lfloor n/m \rfloor + 1",
    reference="D. W. Allan, Proc. IEEE 54, 1966; NIST SP 1065 eq. 8; IEEE Std 952",
    use="To reproduce a data sheet or an older paper; otherwise the overlapping form is better at the same cost.",
    limits="Uses every window only once: at long tau its intervals are up to twice as wide as those of oadev.",
    cost="Less than oadev: n/m terms per tau; one copy of the record.",
    overlapped=False, sums=lambda x, m: allan.strided(x, m, 2), split=interleaved,
    published_edf=partial(greenhall_riley, d=2, overlapped=False),
)  # fmt: skip

HAAR = replace(
    OADEV,
    name="haar",
    synonyms=("haardev",),
    title=say("Haar wavelet (MODWT) deviation"),
    formula=r"\nu^2(\tau) = \tfrac12\,\mathrm{OAVAR}(\tau), \quad \tau = 2^{j-1} \tau_0 \text{ at level } j",
    reference="D. B. Percival & A. T. Walden, Wavelet Methods for Time Series Analysis, 2000, section 8.6",
    meaning="The wavelet variance of the Haar filter: the variance of the rate by time scale.",
    use="To compare with wavelet tools (wv, gmwm): it is exactly half the overlapping Allan variance.",
    limits="Those of oadev. The dyadic scales of the transform are the octave grid; other factors are also allowed.",
    norm=constant(4.0),
)

OHDEV = Statistic(
    name="ohdev", synonyms=("ohvar", "hadamard"), title=say("overlapping Hadamard deviation"),
    formula=r"\frac{1}{6\tau^2 (n+1-3m)} \sum_{i=0}^{n-3m} (x_{i+3m} - 3x_{i+2m} + 3x_{i+m} - x_i)^2",
    reference="NIST SP 1065 eq. 18; R. A. Baugh, 1971",
    meaning="Like the Allan deviation, but of the change of the rate: a constant ramp of the rate cancels.",
    use="With oadev, to distinguish a deterministic drift from rate random walk: only the drift cancels.",
    limits="Below oadev at long tau even without a ramp: by a factor of 0.71 for rate random walk, 0.90 for flicker. "
    "Only a ratio below 0.71 requires a ramp.",
    cost="About 0.3 ns per sample and tau; one copy of the record. All tau together by FFT: 1 us per sample, six "
    "copies.", order=3, norm=constant(6.0), span=(3, 0), sums=partial(dense, order=3),
    split=partial(split, order=3), window=binomial_window(3), differences=3,
    published_edf=partial(greenhall_riley, d=3),
)  # fmt: skip

HDEV = replace(
    OHDEV, name="hdev", synonyms=("hvar",), title=say("Hadamard deviation"),
    formula=r"\frac{1}{6\tau^2 (J-3)} \sum_{j=0}^{J-4} (x_{(j+3)m} - 3x_{(j+2)m} + 3x_{(j+1)m} - x_{jm})^2,"
    r"\quad J = \lfloor n/m \rfloor + 1", reference="NIST SP 1065 eq. 17; R. A. Baugh, 1971",
    use="To reproduce older results; otherwise the overlapping form is better at the same cost.",
    limits="Uses every window only once; otherwise as ohdev.",
    cost="Less than ohdev: n/m terms per tau; one copy of the record.",
    overlapped=False, sums=lambda x, m: allan.strided(x, m, 3), split=interleaved,
    published_edf=partial(greenhall_riley, d=3, overlapped=False),
)  # fmt: skip

MDEV = Statistic(
    name="mdev", synonyms=("mvar", "modadev", "modified"), title=say("modified Allan deviation"),
    formula=r"\frac{1}{2\tau^2 m^2 (n+2-3m)} \sum_{j=0}^{n+1-3m} \Bigl[ \sum_{i=j}^{j+m-1} "
    r"(x_{i+2m} - 2x_{i+m} + x_i) \Bigr]^2", reference="D. W. Allan & J. A. Barnes, 1981; NIST SP 1065 eq. 14",
    meaning="The Allan deviation of an angle smoothed over tau: fast noise is averaged, slow noise is not.",
    use="To distinguish kinds of fast noise: quantization falls with slope -3/2 and flicker angle noise with -1, "
    "while both fall with -1 in oadev.",
    limits="White rate noise gives half its Allan variance, other noise other ratios: coefficients cannot be read off "
    "directly.",
    cost="About 0.4 ns per sample and tau; one copy of the record and segments of 64 tau. All tau together by FFT: "
    "1.5 us per sample.", order=2, norm=lambda m: 2.0 * np.asarray(m, dtype=np.float64) ** 2,
    span=(3, -1), sums=partial(dense, order=3, summed=True),
    split=partial(split, order=3, summed=True), differences=3, summed=True,
    window=lambda m: (np.ones(1), np.repeat([1.0, -2.0, 1.0], m)[None, :]),
    published_edf=partial(greenhall_riley, d=2, modified=True),
)  # fmt: skip

TDEV = replace(
    MDEV,
    name="tdev",
    synonyms=("tvar",),
    title=say("time deviation (TDEV) of the angle"),
    formula=r"\frac{\tau^2}{3}\,\mathrm{MVAR}(\tau)",
    reference="NIST SP 1065 eq. 15",
    meaning="The angle error that accumulates over tau, in the unit of the angle.",
    use="If the angle matters rather than the rate: pointing, dead reckoning between fixes.",
    norm=lambda m: 6.0 * np.asarray(m, dtype=np.float64) ** 2,
    power=1,
)

"""From a model to a record or a recording, and from standard deviations to the noise of a readout."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from allanite.core.aliases import generator, public, size_and_rate
from allanite.core.arrays import FloatArray
from allanite.core.errors import UnitError, UsageError
from allanite.core.model import Model, ModelLike, Term, usable_model
from allanite.core.plain import Header, Value
from allanite.core.record import Record, Recording
from allanite.phrases.phrase import say

MAX_SAMPLES = 10_000_000_000  # most samples of a simulated record, which would take 80 GB
LONGER = (1, 2, 4, 8, 16)  # lengths of embeddings that are tried, over that of the record


@public
def simulate(
    model: ModelLike,
    size: int | None = None,
    rate: float | None = None,
    *,
    duration: float | str | None = None,
    rng: "np.random.Generator | int | None" = None,
    name: str = "",
    unit: str | None = None,
    rounding: bool = False,
) -> Record:
    """Simulate a Gaussian record of a model, exact at every averaging time.

    The first differences of the rate are stationary for every term; their covariance is embedded in a circulant matrix,
    whose eigenvalues are a Fourier transform, and the differences are then summed. Deterministic terms are added by
    their waveform. The mean of the record is zero: a bias is not part of the model.

    Parameters
    ----------
    model : Model, Term or Fit
    size : int
        Number of samples, at least 2; or `duration`, in s or as a text such as ``"1 min"``.
    rate : float
        Sampling rate, Hz.
    rng : numpy.random.Generator or int, optional
        The source of randomness, for example ``numpy.random.default_rng(1)``, or its seed; by default another one each
        time.
    name : str, optional
        Name of the channel.
    unit : str, optional
        Unit of the rates; by default SI.
    rounding : bool
        Makes quantization noise (Q) as a readout does: the angle of the other terms, from a random start, is rounded to
        whole steps of ``Q sqrt(12)`` at each sample, and the rates are its differences. The error of each angle is then
        uniform over a step, with the standard deviation Q, and white where the angle moves by about half a step or
        more from sample to sample; an angle that moves less makes patterns that no term describes. Without, Q is
        Gaussian. The mean of a rounded record is zero except for a step over its duration.

    Returns
    -------
    Record
        Mean rate over each interval. `allanite.simulation.faults` adds other faults.

    Raises
    ------
    UsageError
        Fewer than 2 samples, an impossible rate, or a model without quantization noise that is to be rounded.

    References
    ----------
    C. R. Dietrich, G. N. Newsam, SIAM J. Sci. Comput. 18 (1997) 1088.

    Examples
    --------
    >>> from allanite import N
    >>> record = simulate(N(1.0, "rad/sqrt(s)"), 10_000, 100.0, rng=1)
    >>> bool(9.8 < record.values.std() < 10.2)
    True
    """
    model, rng = usable_model(model), generator(rng)
    size, rate = size_and_rate(size, rate, duration)
    if size < 2:
        raise UsageError(f"a record needs at least 2 samples, not {size}")
    if size > MAX_SAMPLES:
        raise UsageError(f"a simulated record has at most {MAX_SAMPLES:.0e} samples, not {size}: simulate a part of it")
    rounded = None
    if rounding:
        rounded = next((t for t in model if t.row.alpha == 2 and t.value), None)
        if rounded is None:
            raise UsageError(f"rounding generates quantization noise, but there is none in {model}: add Q to the model")
    y = _noise([t for t in model if t is not rounded], size, rate, rng)
    for t in model:
        if (wave := t.sampled(rate).waveform) is not None:
            y += t.value * rate**t.row.power * wave(size)
    y -= y.mean()
    history = say("simulated: {model}", model=str(model))
    if rounded is not None:
        history = say("simulated: {model}, {symbol} by rounding", model=str(model), symbol=rounded.symbol)
        # differences of the running sum of y, from a random start, in whole steps
        step = rounded.value * math.sqrt(12) * rate
        angle = np.concatenate(([0.0], np.cumsum(y / step))) + rng.random()
        y = np.asarray(np.diff(np.rint(angle)) * step)
    record = Record(y, rate, unit or model.signal.unit, model.signal.kind, name=name, history=(history,))
    if record.signal is not model.signal:
        raise UnitError(f"{unit!r} is not a unit of rates of a sensor with {model}")
    y /= record.factor
    return record


def _noise(terms: list[Term], n: int, rate: float, rng: "np.random.Generator") -> FloatArray:
    """Rates with the covariance of the terms of noise, the first of them 0."""
    from scipy.fft import irfft

    parts, y = [(t.power(rate), t.sampled(rate)) for t in terms if t.row.waveform is None and t.value], np.zeros(n)
    if parts:
        # a stationary Gaussian series with the covariance of the increments
        half, power = _embedded(lambda lags: np.asarray(sum(p * row.increments(lags) for p, row in parts)), n - 1)
        np.sqrt(np.maximum(power, 0.0, out=power), out=power)
        noise = rng.standard_normal((half + 1, 2)).view(np.complex128)[:, 0]
        noise[[0, half]] = noise[[0, half]].real * np.sqrt(2.0)
        noise *= power
        y[1:] = irfft(noise, 2 * half)[: n - 1] * np.sqrt(half)
        np.cumsum(y, out=y)
    return y


def _embedded(covariance: Callable[[FloatArray], FloatArray], n: int) -> tuple[int, FloatArray]:
    """Half the length of a circulant matrix that holds the covariance of n values, and its eigenvalues."""
    # An embedding is exact only if no eigenvalue is negative; those of quantization are zero to rounding. A longer one
    # may do where the shortest does not.
    from scipy.fft import next_fast_len, rfft

    for longer in LONGER:
        half = next_fast_len(longer * n, real=True)
        ring = covariance(np.arange(half + 1, dtype=np.float64))
        power = rfft(np.concatenate((ring, ring[half - 1 : 0 : -1]))).real
        if power.min() >= -1e-9 * power.max():
            return half, power
    raise UsageError("this model's covariance has no circulant embedding at this length; choose another length")


def readout_noise(size: int, *, sigma: float, walk: float = 0.0, rng: "np.random.Generator") -> FloatArray:
    """White noise of a readout, and a random walk that begins at 0 and whose steps have the standard deviation `walk`.

    >>> noise = readout_noise(10_000, sigma=2.0, rng=np.random.default_rng(1))
    >>> bool(1.95 < noise.std() < 2.05)
    True
    """
    if size < 1 or not (np.isfinite([sigma, walk]).all() and min(sigma, walk) >= 0):
        raise UsageError(
            f"noise needs at least one sample and standard deviations that are not negative: {size=}, {sigma=}, {walk=}"
        )
    noise = sigma * rng.standard_normal(size)
    if walk:
        noise[1:] += walk * np.cumsum(rng.standard_normal(size - 1))
    return noise


@dataclass(frozen=True, eq=False, repr=False)
class Simulation(Value):
    """The truth of a simulated recording: the noise of every channel, the seed, rate (Hz) and number of samples."""

    # `channels` are what the channels hold; their histories say which faults were put in.
    model: Model
    seed: int
    rate: float
    size: int
    channels: tuple[Header, ...]

    @classmethod
    def of(cls, model: Model, seed: int, recording: Recording) -> "Simulation":
        """The truth of this recording."""
        first = recording[0]
        return cls(model, seed, first.rate, first.size, tuple(record.header for record in recording))

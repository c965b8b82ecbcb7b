"""From a model to a record or a recording, from deviations to noise of a readout; a ring laser gyro with dither."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from allanite.core.aliases import constructed, generator, public, size_and_rate
from allanite.core.arrays import FloatArray
from allanite.core.errors import UnitError, UsageError
from allanite.core.model import Model, ModelLike, N, Q, Term, usable_model
from allanite.core.plain import Header, Value
from allanite.core.ranges import POSITIVE, REAL, SAMPLES, SIZE, TIME, Range
from allanite.core.record import Record, Recording
from allanite.phrases.phrase import say

SIMULATED = Range(2, 10_000_000_000, what="the number of samples of a simulated record")  # 80 GB
LONGER = (1, 2, 4, 8, 16)  # lengths of embeddings that are tried, over that of the record


@public
def simulate(model: ModelLike, size: int | None = None, rate: float | None = None,
             *, duration: float | str | None = None, rng: "np.random.Generator | int | None" = None, name: str = "",
             unit: str | None = None, rounding: bool = False) -> Record:  # fmt: skip
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
    SIMULATED.demand(size)
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


@public
def readout_noise(size: Annotated[int, SAMPLES], *, sigma: Annotated[float, SIZE], walk: Annotated[float, SIZE] = 0.0,
                  rng: "np.random.Generator") -> FloatArray:  # fmt: skip
    """White noise of a readout, and a random walk that begins at 0 and whose steps have the standard deviation `walk`.

    >>> noise = readout_noise(10_000, sigma=2.0, rng=np.random.default_rng(1))
    >>> bool(1.95 < noise.std() < 2.05)
    True
    """
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


@constructed
@dataclass(frozen=True)
class RingLaser:
    """A dithered ring laser gyro, in the units of data sheets.

    Attributes
    ----------
    pulse : float
        Angle of a pulse, arcsec.
    lock_in : float
        Half width of the static lock-in zone, deg/h.
    dither_rate : float
        Amplitude of the dither's rate, deg/s.
    residual : float
        Amplitude of what is left of the dither's angle at the output, arcsec.
    residual_band : (low, high)
        Frequencies among which the residual's lies after sampling, Hz.
    coherence : float
        Time over which the residual keeps its phase, s: the noise that is put on the dither.
    bias : float
        Constant bias, deg/h.
    warm_up, settling : float
        Bias at the start, deg/h, that decays exponentially, and its time constant, s.
    swing : Model, optional
        What the angle and the bias do besides, with the mean zero: GMA within bounds, B and K.

    Examples
    --------
    >>> print(GL1.model)
    N = 0.0002918 deg/sqrt(h), Q = 0.2544 arcsec
    """

    pulse: Annotated[float, POSITIVE]
    lock_in: Annotated[float, SIZE]
    dither_rate: Annotated[float, POSITIVE] = 100.0
    residual: Annotated[float, SIZE] = 0.0
    residual_band: tuple[float, float] = (25.0, 45.0)
    coherence: Annotated[float, TIME] = 0.3
    bias: Annotated[float, REAL] = 0.0
    warm_up: Annotated[float, REAL] = 0.0
    settling: Annotated[float, TIME] = 600.0
    swing: Model | None = None

    def __post_init__(self) -> None:
        low, high = self.residual_band
        if not 0 < low <= high:
            raise UsageError("the band of the residual must be two ascending frequencies in Hz, not "
                             f"{self.residual_band!r}")  # fmt: skip

    @property
    def random_walk(self) -> float:
        r"""Angle random walk that lock-in leaves under dither, N = Omega_L sqrt(K / (2 pi Omega_D)), deg/sqrt(h).

        At each of the dither's turning points the phase gets a kick that depends on where it stands; noise on the
        dither makes the kicks independent. For lock-in that is weak at a turning point (kicks well below a radian).
        """
        pulse, dither = self.pulse / 3600, self.dither_rate * 3600
        return self.lock_in * math.sqrt(pulse / (2 * math.pi * dither))

    @property
    def model(self) -> Model:
        """The noise as terms: N from lock-in, Q from counting and the dither's residual, and `swing`."""
        angle = math.hypot(self.pulse / math.sqrt(12), self.residual / math.sqrt(2))
        noise = Model((Q(angle, "arcsec"),))
        if self.lock_in:
            noise = N(self.random_walk, "deg/sqrt(h)") + noise
        return noise if self.swing is None else noise + self.swing


GL1 = RingLaser(pulse=0.32795, lock_in=45.98, residual=0.334, bias=-0.0948)
"""The gyro GL-1 of Enin and Saneev (2017), as far as the paper's tables determine it.

The pulse and the bias are printed there; random walk and residual fit the scatter of its two-minute means and windows.
True rate 12.4392 deg/h, sampled at 400 Hz.
"""

GL1_SMOOTH = RingLaser(pulse=0.0819875, lock_in=0.0, bias=-0.0948, swing=Model("GMA 0.29 arcsec 15 s"))
"""The same gyro as its means over 1 to 30 s (Table 1 of the paper) and over two minutes (Table 3) have it scatter.

Quarter pulses, and an angle noise that keeps within bounds; whole pulses would scatter more at 1 s. Under it averaging
is as good as Hamming's window: no single noise fits all tables.
"""

RING_LASERS: dict[str, RingLaser] = {"gl1": GL1, "gl1-smooth": GL1_SMOOTH}  # ring laser gyros by name


@public
def simulate_ring_laser(gyro: RingLaser, turning: float, size: int | None = None, rate: float | None = None,
                        *, duration: float | str | None = None, rng: "np.random.Generator | int | None" = None,
                        name: str = "") -> Record:  # fmt: skip
    """Counts of a ring laser gyro that turns at a constant rate.

    Parameters
    ----------
    gyro : RingLaser
    turning : float
        True rate about its axis, deg/h.
    size : int
        Number of samples; or `duration`, s.
    rate : float
        Sampling rate, Hz.
    rng : numpy.random.Generator or int, optional
        The source of randomness, or its seed; by default another one each time.
    name : str, optional

    Returns
    -------
    Record
        Record of kind "count".

    Examples
    --------
    >>> record = simulate_ring_laser(GL1, 12.4392, 48_000, 400.0, rng=np.random.default_rng(1))
    >>> record.kind, record.scale, bool(abs(record.values.sum() - 4513.5) < 10)
    ('count', 0.32795, True)
    """
    size, rate = size_and_rate(size, rate, duration)
    rng = generator(rng)
    SIMULATED.demand(size)
    if not rate > 2 * gyro.residual_band[1]:
        raise UsageError(f"residual dither up to {gyro.residual_band[1]:g} Hz needs more than {rate:g} Hz")
    steps = gyro.random_walk * 60 / math.sqrt(rate) * rng.standard_normal(size)  # deg/sqrt(h) is 60 arcsec/sqrt(s)
    steps += (turning + gyro.bias) / rate  # deg/h is arcsec/s
    if gyro.swing is not None:
        steps += simulate(gyro.swing, size, rate, rng=rng).values * (math.degrees(1.0) * 3600 / rate)
    angle = np.concatenate(([0.0], np.cumsum(steps)))
    t = np.arange(size + 1) / rate
    angle -= gyro.warm_up * gyro.settling * np.expm1(-t / gyro.settling)
    # phase of the residual: a frequency of the band, and a walk that forgets it after the coherence time
    n = size + 1
    frequency = rng.uniform(*gyro.residual_band)
    walk = np.cumsum(rng.standard_normal(n)) * math.sqrt(2 / (gyro.coherence * rate))
    angle += gyro.residual * np.sin(np.asarray(2 * math.pi * (frequency * np.arange(n) / rate + rng.random()) + walk))
    pulses = np.floor(angle / gyro.pulse + rng.random())
    return Record(np.diff(pulses).astype(np.int64), rate, "arcsec", kind="count", scale=gyro.pulse, name=name,
                  history=(say("simulated ring laser turning at {rate:g} deg/h: {gyro}", rate=turning,
                               gyro=str(gyro)),))  # fmt: skip

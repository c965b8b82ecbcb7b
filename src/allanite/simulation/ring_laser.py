"""A simulated ring laser gyro with dither, which delivers counts."""

import math
from dataclasses import dataclass

import numpy as np

from allanite.core.aliases import generator, public, size_and_rate
from allanite.core.errors import UsageError
from allanite.core.model import Model, N, Q
from allanite.core.record import Record
from allanite.phrases.phrase import say

from .record import simulate


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
    wander : Model, optional
        What the bias does besides: B and K.
    swing : Model, optional
        What the angle does besides, within bounds: GMA.

    Examples
    --------
    >>> print(GL1.model)
    N = 0.0002918 deg/sqrt(h), Q = 0.2544 arcsec
    """

    pulse: float
    lock_in: float
    dither_rate: float = 100.0
    residual: float = 0.0
    residual_band: tuple[float, float] = (25.0, 45.0)
    coherence: float = 0.3
    bias: float = 0.0
    warm_up: float = 0.0
    settling: float = 600.0
    wander: Model | None = None
    swing: Model | None = None

    def __post_init__(self) -> None:
        for name in ("pulse", "dither_rate", "coherence", "settling"):
            if not getattr(self, name) > 0:
                raise UsageError(f"{name} of a ring laser must be positive, not {getattr(self, name)!r}")
        for name in ("lock_in", "residual"):
            if not getattr(self, name) >= 0:
                raise UsageError(f"{name} of a ring laser must not be negative, but is {getattr(self, name)!r}")
        low, high = self.residual_band
        if not 0 < low <= high:
            raise UsageError(
                f"the band of the residual must be two ascending frequencies in Hz, not {self.residual_band!r}"
            )

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
        """The noise as terms: N from lock-in, Q from counting and the dither's residual, `wander` and `swing`."""
        angle = math.hypot(self.pulse / math.sqrt(12), self.residual / math.sqrt(2))
        noise = Model((Q(angle, "arcsec"),))
        if self.lock_in:
            noise = N(self.random_walk, "deg/sqrt(h)") + noise
        for more in (self.wander, self.swing):
            noise = noise if more is None else noise + more
        return noise


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
def simulate_ring_laser(
    gyro: RingLaser,
    turning: float,
    size: int | None = None,
    rate: float | None = None,
    *,
    duration: float | str | None = None,
    rng: "np.random.Generator | int | None" = None,
    name: str = "",
) -> Record:
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
    if size < 2:
        raise UsageError(f"a record needs at least 2 samples, not {size}")
    if not rate > 2 * gyro.residual_band[1]:
        raise UsageError(f"residual dither up to {gyro.residual_band[1]:g} Hz needs more than {rate:g} Hz")
    steps = gyro.random_walk * 60 / math.sqrt(rate) * rng.standard_normal(size)  # deg/sqrt(h) is 60 arcsec/sqrt(s)
    steps += (turning + gyro.bias) / rate  # deg/h is arcsec/s
    if gyro.swing is not None:
        steps += simulate(gyro.swing, size, rate, rng=rng).values * (math.degrees(1.0) * 3600 / rate)
    if gyro.wander is not None:
        wander = simulate(gyro.wander, size, rate, rng=rng).values
        steps += (wander - wander[0]) * (math.degrees(1.0) * 3600 / rate)
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

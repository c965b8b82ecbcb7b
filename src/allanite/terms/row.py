"""Definition of a noise term: a row of the table, and its state-space form."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from allanite.phrases.phrase import say

FloatArray = NDArray[np.float64]

WHITE = -0.5
"""Slope of white rate noise."""

FAR = 1e15
"""A time, in sample intervals, that is long beside any time constant."""

LONGEST = 0.1
"""Share of a record up to which a time constant can be distinguished from a random walk."""


@dataclass(frozen=True)
class Parameter:
    """What a term has beside its coefficient.

    `title` is its name as text, `least` what its value must exceed, None if it may be anything; `default` stands where
    none is given; `letter` is what it is called in print, and `typical` a value for examples. Its unit contains the
    second to the power `time`. `search` gives the least and the greatest value that a record of n samples tells of, in
    sample intervals, and `steps` how many a decade are tried at first.
    """

    name: str
    title: str
    unit: str
    least: float | None = None
    default: float | None = None
    letter: str = ""
    typical: float = 1.0
    time: float = 0.0
    search: Callable[[int], tuple[float, float]] | None = None
    steps: int = 4


def time_constant(typical: float, shortest: float = 0.0) -> Parameter:
    """The time constant T of a term; looked for from `shortest` sample intervals on, where that is given."""
    return Parameter(
        "time_constant", say("time constant"), "s", least=0.0, letter="T", typical=typical, time=1.0,
        search=(lambda n: (shortest, max(LONGEST * n, 2 * shortest))) if shortest else None,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Block:
    """A noise term as states z of a filter: exact transition over a sample interval, and the mean over it.

    With dz = F z dt + w, the covariance of w being Qc per second, it is over an interval h

        z(h) = Phi z(0) + noise,      mean of the first state over the interval = mean z(0) + noise,

    with the joint covariance of both noises in closed form.

    Attributes
    ----------
    names : tuple of (str, float)
        Description of each state, and the power of time that its unit carries beyond the signal.
    F, Qc : arrays, shape (s, s)
        Continuous time.
    Phi : array, shape (s, s)
    mean : array, shape (s,)
        What a state at the start adds to the mean over the interval.
    Q : array, shape (s + 1, s + 1)
        Covariance of the noises of the states and, last, of the mean.
    P0 : array, shape (s, s)
        Covariance at the start.
    output : array, shape (s,)
        What a state adds to the rate at an instant; 0 for a state of discrete time.
    white : float
        Variance of the white noise that each measurement gets besides.
    bias : bool
        Whether the states are the bias and its derivatives, which such blocks of a model have in common.
    note : str
        Remark for users of the filter.
    """

    names: tuple[tuple[str, float], ...]
    F: FloatArray
    Qc: FloatArray
    Phi: FloatArray
    mean: FloatArray
    Q: FloatArray
    P0: FloatArray
    output: FloatArray
    white: float = 0.0
    bias: bool = False
    note: str = ""


@dataclass(frozen=True)
class NoiseTerm:
    """A row of `TERMS`.

    Attributes
    ----------
    symbol, title, meaning, formula, reference
        Names, description, LaTeX formula (Allan variance) and source; the title is that for a gyro.
    titles : {name of a signal: title}
        Where it is called otherwise.
    quantity_title : str
        What it is called where the signal is not the output of an inertial sensor, such as a voltage: a template with
        its {quantity}.
    quantity_meaning : str
        Its description there, if it differs.
    power : float
        The coefficient is a signal times time to this power.
    slope : float
        Slope of log Allan deviation against log tau.
    read_at : float
        The asymptote, a straight line of that slope, has the value of the coefficient at this tau (in units of time);
        1 where it has not at any, or where that depends on the rate.
    level : float
        Allan variance of the term at tau = 1 for a coefficient of 1.
    structure : t -> D(t)
        For t >= 0.
    derivative : (order, t) -> d^order D/dt^order
        For t > 0 and orders from 1 on: the far field of D, where differences of D itself would cancel.
    summed : l -> E(l)
        Second sum of D over integers, ``E(l+1) - 2 E(l) + E(l-1) = D(l)``, except for a square of l, which the
        statistics remove; for l >= 0, and between the integers from l = 3 on.
    increments : h -> covariance of the first differences of the rate, at lag h >= 0 samples.
    spectrum : (f, tau0) -> two-sided spectral density of the sampled rate, its mean over each tau0, aliases included.
        For 0 < f <= 1 / (2 tau0).
    dct : (k, n) -> variance of the k-th coefficient of the orthonormal DCT-II of n rates.
    dct_error : float
        Relative error of `dct` for 60 rates and more, at most, where it is an approximation.
    edge : float
        Variance that the first and the last rate have beyond that, of white angle noise.
    ends : float
        The same of an angle error that is forgotten within a record.
    waveform : n -> the rate itself, for a deterministic term of coefficient 1; None for noise.
    periodic : bool
        A spectral line: its structure function is the mean over its phase, and it adds nothing to the scatter of an
        estimate.
    period : float
        Period of a covariance that oscillates and decays, in sample intervals; 0 if it does not.
    transient : bool
        A deterministic term that begins with the record: what it adds to a statistic depends on the record's length, it
        has no structure function, and it adds nothing to the scatter of an estimate.
    parameters : tuple of Parameter
        What a term has beside its coefficient: a time constant, a frequency.
    shape : tuple of float
        The values of `parameters` that the functions of this row hold for, at a sample interval of 1.
    shaped : (shape, rate) -> the row of another shape (in SI), at a sample interval of 1 / rate.
    density : str
        LaTeX of the two-sided spectral density of the rate, at frequencies far below the sampling rate except for Q.
    origin, advice : str
        For the documentation: its origin, and how to read it off and use it.
    typical : float
        For the documentation: an example coefficient, in the data-sheet unit of gyros.
    color, dark : str
        Color of its line and name on a light and on a dark ground, ``#RRGGBB``.
    dash : tuple of float
        Lengths of the dashes and gaps of its line, in line widths.
    alpha : int or None
        Exponent of the spectral density of the rate, where that is one power of the frequency.
    per_sample : bool
        Whether D in units of the sample interval is the same at every rate, as of noise that begins with the sampling:
        its expectation then depends on the rate.
    automatic : bool
        Whether it is among the default terms.
    block : (coefficient, shape, interval) -> Block, or None
        What it is as states of a Kalman filter, SI; None where a finite filter has none.
    substitute : str
        Symbol of a term with a time constant which may take its place: itself where a record says so, in a filter as a
        sum of several. For flicker of the rate.
    second : str
        Symbol of the same noise with a longer time constant, for which a second one of this symbol stands.
    synonyms : tuple of str
        Other names by which it is asked for; they are suggested, not taken.
    """

    symbol: str
    title: str
    meaning: str
    formula: str
    reference: str
    power: float
    slope: float
    read_at: float
    level: float
    structure: Callable[[FloatArray], FloatArray]
    derivative: Callable[[int, FloatArray], FloatArray]
    summed: Callable[[FloatArray], FloatArray]
    increments: Callable[[FloatArray], FloatArray]
    spectrum: Callable[[FloatArray, float], FloatArray]
    dct: Callable[[FloatArray, int], FloatArray]
    dct_error: float = 0.0
    edge: float = 0.0
    ends: float = 0.0
    waveform: Callable[[int], FloatArray] | None = None
    periodic: bool = False
    transient: bool = False
    period: float = 0.0
    parameters: tuple[Parameter, ...] = ()
    shape: tuple[float, ...] = ()
    shaped: "Callable[[tuple[float, ...], float], NoiseTerm] | None" = None
    density: str = ""
    origin: str = ""
    advice: str = ""
    typical: float = 1.0
    color: str = "#6B6B6B"
    dark: str = "#A0A7AE"
    dash: tuple[float, ...] = (5.0, 3.0)
    alpha: int | None = None
    per_sample: bool = False
    automatic: bool = False
    block: Callable[[float, tuple[float, ...], float], Block] | None = None
    substitute: str = ""
    second: str = ""
    titles: Mapping[str, str] = field(default_factory=dict)
    synonyms: tuple[str, ...] = ()
    quantity_title: str = ""
    quantity_meaning: str = ""

    @property
    def scatters(self) -> bool:
        """Whether it takes part in the scatter of an estimate: noise, and a ramp, whose product with noise does."""
        return not (self.periodic or self.transient)

    @property
    def growth(self) -> float:
        """Exponent with which D grows at long times; of flicker it is a little more than 2, for its logarithm."""
        D = self.structure(FAR * np.array([1.0, 2.0]))
        return float(np.log2(D[1] / D[0]))

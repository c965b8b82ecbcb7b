"""Definition of a noise term: a row of the table, and its state-space form."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from allanite.phrases.phrase import say

FloatArray = NDArray[np.float64]

WHITE = -0.5  # slope of white rate noise
FAR = 1e15  # a time, in sample intervals, that is long beside any time constant
LONGEST = 0.1  # share of a record up to which a time constant can be distinguished from a random walk


@dataclass(frozen=True)
class Parameter:
    """What a term has beside its coefficient."""

    # `title` is its name as text, `least` what its value must exceed, None if it may be anything; `default` stands
    # where none is given; `letter` is what it is called in print, and `typical` a value for examples. Its unit contains
    # the second to the power `time`. `search` gives the least and the greatest value that a record of n samples tells
    # of, in sample intervals, and `steps` how many a decade are tried at first.
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
    return Parameter("time_constant", say("time constant"), "s", least=0.0, letter="T", typical=typical, time=1.0,
                     search=(lambda n: (shortest, max(LONGEST * n, 2 * shortest))) if shortest else None)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Block:
    """A noise term as states z of a filter: exact transition over a sample interval, and the mean over it."""

    # With dz = F z dt + w, the covariance of w being Qc per second, it is over an interval h
    #     z(h) = Phi z(0) + noise,      mean of the first state over the interval = mean z(0) + noise,
    # with the joint covariance of both noises in closed form.
    # description of each state, and the power of time that its unit carries beyond the signal
    names: tuple[tuple[str, float], ...]
    # F, Qc: shape (s, s); continuous time
    F: FloatArray
    Qc: FloatArray
    Phi: FloatArray  # shape (s, s)
    mean: FloatArray  # shape (s,); what a state at the start adds to the mean over the interval
    Q: FloatArray  # shape (s + 1, s + 1); covariance of the noises of the states and, last, of the mean
    P0: FloatArray  # shape (s, s); covariance at the start
    output: FloatArray  # shape (s,); what a state adds to the rate at an instant; 0 for a state of discrete time
    white: float = 0.0  # variance of the white noise that each measurement gets besides
    # whether the states are the bias and its derivatives, which such blocks of a model have in common
    bias: bool = False
    note: str = ""  # remark for users of the filter


@dataclass(frozen=True, eq=False)
class NoiseTerm:
    """A row of `TERMS`."""

    # symbol, title, meaning, formula, reference: names, description, LaTeX formula (Allan variance) and source; the
    # title is that for a gyro
    symbol: str
    title: str
    meaning: str
    formula: str
    reference: str
    power: float  # the coefficient is a signal times time to this power
    slope: float  # slope of log Allan deviation against log tau
    # the asymptote, a straight line of that slope, has the value of the coefficient at this tau (in units of time); 1
    # where it has not at any, or where that depends on the rate
    read_at: float
    level: float  # Allan variance of the term at tau = 1 for a coefficient of 1
    structure: Callable[[FloatArray], FloatArray]  # for t >= 0
    # for t > 0 and orders from 1 on: the far field of D, where differences of D itself would cancel
    derivative: Callable[[int, FloatArray], FloatArray]
    # second sum of D over integers, ``E(l+1) - 2 E(l) + E(l-1) = D(l)``, except for a square of l, which the
    # statistics remove; for l >= 0, and between the integers from l = 3 on
    summed: Callable[[FloatArray], FloatArray]
    increments: Callable[[FloatArray], FloatArray]
    spectrum: Callable[[FloatArray, float], FloatArray]  # for 0 < f <= 1 / (2 tau0)
    dct: Callable[[FloatArray, int], FloatArray]
    dct_error: float = 0.0  # relative error of `dct` for 60 rates and more, at most, where it is an approximation
    edge: float = 0.0  # variance that the first and the last rate have beyond that, of white angle noise
    ends: float = 0.0  # the same of an angle error that is forgotten within a record
    waveform: Callable[[int], FloatArray] | None = None
    # a spectral line: its structure function is the mean over its phase, and it adds nothing to the scatter of an
    # estimate
    periodic: bool = False
    # a deterministic term that begins with the record: what it adds to a statistic depends on the record's length, it
    # has no structure function, and it adds nothing to the scatter of an estimate
    transient: bool = False
    period: float = 0.0  # period of a covariance that oscillates and decays, in sample intervals; 0 if it does not
    parameters: tuple[Parameter, ...] = ()  # what a term has beside its coefficient: a time constant, a frequency
    # the values of `parameters` that the functions of this row hold for, at a sample interval of 1
    shape: tuple[float, ...] = ()
    shaped: "Callable[[tuple[float, ...], float], NoiseTerm] | None" = None  # shape (in SI)
    # LaTeX of the two-sided spectral density of the rate, at frequencies far below the sampling rate except for Q
    density: str = ""
    # origin, advice: for the documentation: its origin, and how to read it off and use it
    origin: str = ""
    advice: str = ""
    typical: float = 1.0  # for the documentation: an example coefficient, in the data-sheet unit of gyros
    # color, dark: color of its line and name on a light and on a dark ground, ``#RRGGBB``
    color: str = "#6B6B6B"
    dark: str = "#A0A7AE"
    dash: tuple[float, ...] = (5.0, 3.0)  # lengths of the dashes and gaps of its line, in line widths
    alpha: int | None = None  # exponent of the spectral density of the rate, where that is one power of the frequency
    # whether D in units of the sample interval is the same at every rate, as of noise that begins with the sampling:
    # its expectation then depends on the rate
    per_sample: bool = False
    automatic: bool = False  # whether it is among the default terms
    # what it is as states of a Kalman filter, SI; None where a finite filter has none
    block: Callable[[float, tuple[float, ...], float], Block] | None = None
    # symbol of a term with a time constant which may take its place: itself where a record says so, in a filter as a
    # sum of several. For flicker of the rate.
    substitute: str = ""
    # symbol of the same noise with a longer time constant, for which a second one of this symbol stands
    second: str = ""
    # where it is called otherwise. One of name of a signal: title.
    titles: Mapping[str, str] = field(default_factory=dict)
    synonyms: tuple[str, ...] = ()  # other names by which it is asked for; they are suggested, not taken
    # what it is called where the signal is not the output of an inertial sensor, such as a voltage: a template with
    # its {quantity}
    quantity_title: str = ""
    quantity_meaning: str = ""  # its description there, if it differs

    @property
    def scatters(self) -> bool:
        """Whether it takes part in the scatter of an estimate: noise, and a ramp, whose product with noise does."""
        return not (self.periodic or self.transient)

    @property
    def growth(self) -> float:
        """Exponent with which D grows at long times; of flicker it is a little more than 2, for its logarithm."""
        D = self.structure(FAR * np.array([1.0, 2.0]))
        return float(np.log2(D[1] / D[0]))

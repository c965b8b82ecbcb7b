"""StateSpace: a model of the sensor's error for a Kalman filter."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from allanite.core.aliases import public
from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import StoredError, UsageError
from allanite.core.limits import demand_stored_rate
from allanite.core.model import Model, ModelLike, usable_model
from allanite.core.plain import Value
from allanite.core.ranges import SAMPLES, SIZE
from allanite.phrases.phrase import say, say_count
from allanite.statistics.moments.moments import expected
from allanite.terms.row import Block

from .build import MEASUREMENTS, MarkovSum, Matrices, blocks_of, continuous, equivalent, flicker_sum, states_of

NEGLIGIBLE = 0.01
"""Relative deviation of the Allan variance below which the mean over an interval is replaced by the rate at its end."""

STEPS = "the number of steps in the longest averaging time"

PER_OCTAVE = 4  # averaging times at which a state space is compared with the model


@dataclass(frozen=True, eq=False, repr=False)
class StateSpace(Matrices, Value):
    """Errors of a sensor as states: x' = Phi x + w, z = H x + v, cov(w) = Qd, var(v) = R, cov(x at start) = P0.

    Attributes
    ----------
    Phi, Qd, P0 : arrays, shape (s, s)
    H : array, shape (1, s)
    R : array, shape (1, 1)
    F, Qc : arrays, shape (c, c)
        Continuous time, of the first c states: dx = F x dt + noise of density Qc. The others are of discrete time.
    states, units : tuples of str
        What each state is, and its SI unit.
    rate : float
        Steps per second, Hz.
    measurement : {"mean", "sample"}
        See `MEASUREMENTS`.
    model, equivalent : Model
        The given model, and the equivalent one: flicker as Gauss-Markov processes.
    tau : (low, high)
        Range of averaging times in which it represents the model, s.
    ripple : float
        Largest relative deviation of its Allan deviation from the model's in that range.
    notes : tuple of str
        What is neglected, and what the user must set.
    """

    _alike = ("states units",)
    _checks: ClassVar = {"rate": demand_stored_rate}

    F: FloatArray
    Qc: FloatArray
    states: tuple[str, ...]
    units: tuple[str, ...]
    rate: float
    measurement: str
    model: Model
    equivalent: Model
    tau: tuple[float, float]
    ripple: float
    notes: tuple[str, ...]

    @property
    def factors(self) -> IntArray:
        """Averaging factors at octaves, from 1 to the end of the range."""
        last = max(1, math.floor(self.tau[1] * self.rate))
        return 2 ** np.arange(last.bit_length(), dtype=np.int64)

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Headings and rows: the states."""
        headings = ["state", "unit", "Phi", "Qd", "P0", "H"]
        diagonals = (np.diag(self.Phi), np.diag(self.Qd), np.diag(self.P0), self.H[0])
        columns = (self.states, self.units, *(d.tolist() for d in diagonals))
        return headings, [list(row) for row in zip(*columns, strict=True)]

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Plain data, SI, with the Allan variance of the measurements; `level` changes nothing."""
        m = self.factors
        allan = {"m": m.tolist(), "tau": (m / self.rate).tolist(), "variance": self.allan(m).tolist()}
        return super().to_dict(level) | {"allan": allan}

    @classmethod
    def _stored(cls, data: dict[str, Any]) -> "StateSpace":
        space = super()._stored(data)
        # a list of no rows does not say that it has no columns either
        square = {n: getattr(space, n) for n in ("Phi", "Qd", "P0", "F", "Qc")}
        orders = {n: math.isqrt(matrix.size) for n, matrix in square.items()}
        if any(matrix.size != orders[n] ** 2 for n, matrix in square.items()):
            raise StoredError("a matrix is not square")
        if not all(np.isfinite(matrix).all() for matrix in (*square.values(), space.H, space.R)):
            raise StoredError("a matrix has numbers that are not finite")
        if len({orders["Phi"], orders["Qd"], orders["P0"], space.H.size}) > 1 or orders["F"] != orders["Qc"]:
            raise StoredError("the matrices are not of one size: the data were changed")
        SAMPLES.demand(max(space.tau[1] * space.rate, 1.0), STEPS)
        square = {n: matrix.reshape((orders[n], orders[n])) for n, matrix in square.items()}
        return replace(space, H=space.H.reshape(1, -1), **square)

    def _summary(self) -> str:
        return f"{', '.join(self.states) or 'no states'} at {self.rate:g} Hz: {self.model}"


@public
def state_space(model: ModelLike, rate: float, *, tau: tuple[float, float] = (1.0, 1000.0), ripple: float = 0.02,
                order: int | None = None, turn_on: float = 0.0, measurement: str = "auto") -> StateSpace:  # fmt: skip
    """Convert a model to a state space, discretized exactly at a rate.

    White noise N is the noise of the measurement, R = N^2 rate. A rate random walk and a ramp are a bias and its slope.
    Gauss-Markov noise is a state each. Flicker, which has no finite-dimensional state model, is approximated by a sum
    of Gauss-Markov processes with the same Allan variance between two averaging times. Quantization is white noise of
    the angle: a state, whose difference over the interval the measurement gets. A sinusoid is an oscillator of known
    frequency.

    Parameters
    ----------
    model : Model, Term or Fit
    rate : float
        Rate of the filter's steps and measurements, Hz.
    tau : (low, high)
        Averaging times between which flicker is matched, s; low is at least an interval.
    ripple : float
        Largest relative deviation from the Allan deviation of flicker; it determines the number of processes.
    order : int, optional
        Or the number of processes that approximate flicker.
    turn_on : float
        Standard deviation of the turn-on bias, SI, which the noise does not determine.
    measurement : {"auto", "mean", "sample"}
        Whether the mean over the interval is a state of its own ("mean", exact), or the rate at the end is taken for it
        ("sample"); "auto" takes the latter where it changes the Allan variance by less than 1 %.

    Returns
    -------
    StateSpace

    Raises
    ------
    UsageError
        The model has no states, or a term without a state model; an option is impossible.

    Examples
    --------
    >>> from allanite import B, N
    >>> space = state_space(N(0.01, "deg/sqrt(h)") + B(0.5, "deg/h"), 100.0, tau=(10.0, 1000.0))
    >>> space.Phi.shape, space.measurement, space.ripple < 0.02
    ((3, 3), 'sample', True)
    """
    model = usable_model(model)
    for term in model:
        term.sampled(rate)  # refuses a time constant that the rate does not suit
    SIZE.demand(turn_on, "the turn-on bias, SI,")
    if measurement not in ("auto", *MEASUREMENTS):
        raise UsageError(f"measurement must be auto, {' or '.join(MEASUREMENTS)}, not {measurement!r}")
    low, high = max(tau[0], 1 / rate), tau[1]
    SAMPLES.demand(max(high * rate, 1.0), STEPS)
    fitted = flicker_sum((low, high), ripple=ripple, order=order) if any(t.row.substitute for t in model) else None
    replaced = equivalent(model, fitted)
    every = blocks_of(replaced, 1 / rate)
    blocks = states_of(every, turn_on, 1 / rate)
    white = np.array([[sum(block.white for block in every)]])
    if not blocks:
        raise UsageError(f"{model} is measurement noise alone, with variance {white[0, 0]:g} ({model.signal.unit})^2")
    chosen = _chosen(measurement, blocks, white, (replaced, rate, high))
    built = MEASUREMENTS[chosen].build(blocks, white)
    m = _factors(low, high, rate)
    off = np.sqrt(_ratio(built, model, m, rate)) - 1
    names = [name for block in blocks for name in block.names]
    names += [(say("mean rate over the interval"), 0.0)] if len(built.Phi) > len(names) else []
    F, Qc = continuous(blocks)
    return StateSpace(**vars(built), F=F, Qc=Qc, states=tuple(name for name, _ in names),
                      units=tuple(model.signal.si[power] for _, power in names), rate=float(rate), measurement=chosen,
                      model=model, equivalent=replaced, tau=(low, high), ripple=float(np.abs(off).max()),
                      notes=tuple(_notes(every, fitted, (low, high), turn_on)))  # fmt: skip


def _chosen(measurement: str, blocks: list[Block], white: FloatArray, how: tuple[Model, float, float]) -> str:
    """The measurement that was requested, or for "auto" the simpler one if it is good enough."""
    model, rate, high = how
    angle = any(block.Q.any() and not block.output.any() for block in blocks)
    if measurement == "sample" and angle:
        raise UsageError("angle noise is a difference over the interval: it needs measurement='mean'")
    if measurement != "auto":
        return measurement
    m = _factors(1 / rate, high, rate)
    off = _ratio(MEASUREMENTS["sample"].build(blocks, white), model, m, rate) - 1
    return "mean" if angle or np.abs(off).max() > NEGLIGIBLE else "sample"


def _ratio(built: Matrices, model: Model, m: IntArray, rate: float) -> FloatArray:
    """The Allan variance of a state model over that of the noise; 1 without noise."""
    wanted = expected(model, "oadev", m / rate)
    return np.divide(built.allan(m), wanted, out=np.ones(m.size), where=wanted > 0)


def _factors(low: float, high: float, rate: float) -> IntArray:
    """Averaging factors from one averaging time to another."""
    first, last = max(1.0, low * rate), max(1.0, high * rate)
    count = max(2, math.ceil(PER_OCTAVE * math.log2(last / first)) + 1)
    return np.unique(np.rint(np.geomspace(first, last, count)).astype(np.int64))


def _notes(blocks: list[Block], fitted: MarkovSum | None, tau: tuple[float, float], turn_on: float) -> Iterator[str]:
    if fitted is not None:
        k = int((fitted.sizes > 0).sum())
        yield say_count(k, "flicker is approximated by {count} Gauss-Markov process, within {ripple:.2g} % of its "
                        "Allan deviation from {low:g} to {high:g} s; below, its power is too small, and beyond, the "
                        "bias drifts no further",
                        "flicker is approximated by {count} Gauss-Markov processes, within {ripple:.2g} % of its "
                        "Allan deviation from {low:g} to {high:g} s; below, its power is too small, and beyond, the "
                        "bias drifts no further", ripple=100 * fitted.ripple, low=tau[0], high=tau[1])  # fmt: skip
    yield from dict.fromkeys(block.note for block in blocks if block.note)
    if not turn_on:
        yield say("the turn-on bias is not part of the noise: it is 0 in P0 unless given (turn_on)")

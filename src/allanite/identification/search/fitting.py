"""The fit of a state: sizes and shapes together, by Fisher scoring of one score (docs/derivations.md)."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from allanite.core.arrays import BoolArray, FloatArray
from allanite.core.plain import Portable
from allanite.identification.likelihood.likelihood import Likelihood
from allanite.identification.likelihood.whittle import step_products

from .components import ANGLE, BEHIND, COMPONENTS, STEP, Part
from .frame import DIRECTIONS, Frame, leak
from .state import State

SHAPE_ERRORS = np.array([0.01, 0.03, 0.1, 0.3])
"""Errors of the shapes of resonances that are tried, RMS of their own power in each bin."""

STEEPEST = 25.0  # logarithm of a factor, at most: beyond it nothing is left to multiply


@dataclass(frozen=True, eq=False)
class Fitted(Portable):
    """A state with its sizes."""

    frame: Frame
    state: State
    # shape (sizes,); sizes that may be above zero: of the powers, of noise in the sensor, of floor and resonances
    free: BoolArray
    theta: FloatArray  # shape (sizes,)
    v: FloatArray  # shape (k,); coefficients of the factors
    likelihood: Likelihood  # of the bins that are read
    trust: FloatArray | None  # shape (bins,); weights of the bins, where a shape is not known exactly
    of: tuple[FloatArray, ...]  # power, expectation, the part of it that is not the terms', count: with these weights
    value: float

    @cached_property
    def trusted(self) -> Likelihood:
        """The likelihood with the weights of its bins."""
        return self.likelihood if self.trust is None else self.likelihood.trusted(self.trust)

    @cached_property
    def score(self) -> float:
        """The value and the costs of its parts and terms."""
        return self.value + self.cost

    @cached_property
    def cost(self) -> float:
        """What its parts and terms cost."""
        frame, state = self.frame, self.state
        free = self.free[: len(frame.powers)]
        angle = BEHIND if state.rises else ANGLE
        terms = COMPONENTS["term"].cost(frame.size) * int(free.sum()) + angle * int((free & frame.angle).sum())
        return state.cost(frame) + terms

    @cached_property
    def completed(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Power, its expectation and half the count, of the bins and the finite directions."""
        power, m, rest, count = self.of
        return power - rest, m, count / 2

    @cached_property
    def m(self) -> FloatArray:
        """Expected power of the bins."""
        return self.likelihood.expectation(self.theta)

    @cached_property
    def residual(self) -> FloatArray:
        """Power over the expected one, less 1, of the bins."""
        power, m, _ = self.completed
        return (power / m)[: self.m.size] - 1

    @cached_property
    def inside(self) -> FloatArray:
        """Expected power of what the filter and the factors act on, shape (bins,)."""
        k = sizes_inside(self.frame, self.state)
        return np.asarray(self.likelihood.S[:, :k] @ self.theta[:k])

    @cached_property
    def slopes(self) -> FloatArray:
        """Derivatives of m by the shapes' logarithms and then by v, shape (values, bins)."""
        frame, state, theta = self.frame, self.state, self.theta
        gain = frame.gain(state.filter.label, state.filter.shape[0]) if state.filter else np.ones(1)
        basis = factor_basis(frame, state)
        acting = gain * raised(basis @ self.v) if self.v.size else gain
        rows, inner, outer = [], len(frame.powers), sizes_inside(frame, state)
        columns = [column_of_part(state, frame, p) for p in state if COMPONENTS[p.name].behind]
        behind = frame.spectrum.rounding + sum(float(theta[i]) for i in columns if i is not None)
        for part in state:
            row = COMPONENTS[part.name]
            if row.inside and row.slope is not None:
                rows += list(theta[inner] * row.slope(frame, part) * acting)
                inner += 1
            elif part.name == "filter":
                moved = frame.gain(part.label, part.shape[0] * math.exp(-STEP))
                change = (gain - moved) / STEP
                rows.append(change * (self.inside / gain - behind))
            elif row.slope is not None:
                rows += list(theta[outer] * row.slope(frame, part))
                outer += 1
        return np.vstack((np.array(rows).reshape(-1, frame.count.size), (basis * self.inside[:, None]).T))

    @cached_property
    def information(self) -> tuple[FloatArray, BoolArray]:
        """Information of the active sizes, shapes and v; and which sizes are active."""
        active = self.theta > 0
        Z = self.directions
        _, m, h = self.completed
        H = (Z * (h / (m * m))) @ Z.T
        k = self.v.size
        if k:
            H[-k:, -k:].flat[:: k + 1] += 1
        through = self.state.filter
        if through is not None:
            at = int(active.sum()) + place_of(self.state, through)
            H[at, at] += self.frame.told(through.label, through.shape[0])[2] / 2
        return H, active

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance of what the information is of; what the record does not distinguish shares it."""
        H, _ = self.information
        size = np.sqrt(np.maximum(np.diag(H), 1e-300))
        units = np.outer(size, size)
        with np.errstate(over="ignore"):  # of what has no information it is infinite
            return np.asarray(np.linalg.pinv(H / units, hermitian=True) / units)

    def loss(self, which: int) -> float:
        """What the value would rise by without a size, by one step."""
        if self.theta[which] <= 0:
            return 0.0
        at = int(np.count_nonzero(self.theta[:which] > 0))
        return float(self.theta[which] ** 2 / max(self.covariance[at, at], 1e-300))

    @cached_property
    def directions(self) -> FloatArray:
        """Derivatives of the expectation by the active sizes, the shapes and v, shape (values, bins and directions)."""
        columns, slopes = self.likelihood.columns[self.theta > 0], self.slopes
        Z = np.zeros((columns.shape[0] + slopes.shape[0], columns.shape[1]))
        Z[: columns.shape[0]], Z[columns.shape[0] :, : slopes.shape[1]] = columns, slopes
        return Z


def sizes_inside(frame: Frame, state: State) -> int:
    """Number of sizes that the filter acts on: they come first."""
    return len(frame.powers) + sum(COMPONENTS[p.name].inside for p in state)


def column_of_part(state: State, frame: Frame, part: Part) -> int | None:
    """The place of the size of a part among the columns; None for a part without one."""
    inner = [p for p in state if COMPONENTS[p.name].inside]
    outer = [p for p in state if COMPONENTS[p.name].power is not None and not COMPONENTS[p.name].inside]
    columns = [*inner, *outer]
    return len(frame.powers) + columns.index(part) if part in columns else None


def values_of(state: State) -> FloatArray:
    """Logarithms of the shapes that are refined, in the order of the parts."""
    return np.array([math.log(x) for p in state for x in p.shape[: refined_values(p)]])


def refined_values(part: Part) -> int:
    """How many values of a part's shape are refined with the sizes."""
    return len(part.shape) if part.name == "noise" else COMPONENTS[part.name].refined


def place_of(state: State, part: Part) -> int:
    """Place of the first value of a part among those that are refined."""
    return sum(refined_values(other) for other in state.parts[: state.parts.index(part)])


def with_values(state: State, x: FloatArray) -> State:
    """The state with other shapes; its parts keep their order."""
    values, parts = iter(np.exp(x).tolist()), []
    for part in state:
        k = refined_values(part)
        parts.append(part._replace(shape=(*(next(values) for _ in range(k)), *part.shape[k:])) if k else part)
    return State(tuple(parts))


def bounds_of(frame: Frame, state: State) -> tuple[FloatArray, FloatArray]:
    """Least and greatest logarithms of the shapes."""
    ends = [end for p in state if refined_values(p) for end in COMPONENTS[p.name].bounds(frame, p)]
    low, high = np.log(np.array(ends).reshape(-1, 2)).T
    return low, high


def factor_basis(frame: Frame, state: State) -> FloatArray:
    """B L of all factors side by side, shape (bins, k)."""
    parts = state.of("factor")

    def computed() -> FloatArray:
        if not parts:
            return np.zeros((frame.count.size, 0))
        return np.column_stack([p.shape[2] * frame.splines.basis((p.label, p.shape[0], p.shape[1])) for p in parts])

    return frame.remembered(("factors", parts), computed)


def likelihood_of(frame: Frame, state: State, v: FloatArray) -> Likelihood:
    """The likelihood of a state, its sizes being the columns."""
    more = tuple((p.name, p.shape[0]) for p in state if p.name in DIRECTIONS)
    part = frame.beside(more)
    gain, through = np.ones(1), state.filter
    if through is not None:
        which = through.label, through.shape[0]
        gain = frame.gain(*which)
        part = part.edged(gain, frame.mean_gain(*which), leak(*which), frame.white)
    powers, acting = part.S.shape[1], gain
    if v.size:
        acting = gain * raised(factor_basis(frame, state) @ v)
    rows, inner = [], powers
    for p in state:
        row = COMPONENTS[p.name]
        if row.power is not None and row.inside:
            rows.append(row.power(frame, p))  # before all others: parts are in the order of the table
            inner += 1
        elif row.power is not None:
            rows.append(row.power(frame, p) * (1 - gain) if row.behind else row.power(frame, p))
    columns = np.empty((powers + len(rows), part.S.shape[0]))
    columns[:powers] = part.S.T
    for i, each in enumerate(rows):
        columns[powers + i] = each
    if acting.size > 1:
        columns[:inner] *= acting
    W = np.zeros((part.W.shape[0], columns.shape[0]))
    W[:, :powers] = part.W
    explained = part.explained(columns.T, W)
    rounding = frame.spectrum.rounding
    if rounding and through is not None:
        explained = explained.adding(rounding * (1 - gain))
    return explained


def raised(logarithm: FloatArray) -> FloatArray:
    """The power of factors from its logarithm."""
    return np.exp(np.minimum(np.maximum(logarithm, -STEEPEST), STEEPEST))


def admissible(frame: Frame, state: State, free: BoolArray | None, sizes: int) -> BoolArray:
    """Which sizes may be above zero."""
    every = np.ones(sizes, dtype=bool)
    if free is not None:
        every[: len(frame.powers)] = free[: len(frame.powers)]
    if state.lacks_flicker and frame.flicker is not None:
        every[frame.flicker] = False
    if state.hides_angle:
        every[: len(frame.powers)][frame.angle] = False
    if state.needs_white and frame.white is not None:
        every[frame.white] = True
    return every


def fitted(
    frame: Frame, state: State, free: BoolArray | None = None, start: Fitted | None = None, v: FloatArray | None = None
) -> Fitted:
    """The sizes of a state at its shapes."""
    rank = factor_basis(frame, state).shape[1]
    v = np.zeros(rank) if v is None or v.size != rank else v
    part = likelihood_of(frame, state, v)
    may = admissible(frame, state, free, part.S.shape[1])
    first = start.theta if start is not None and start.theta.size == may.size and (start.theta[may] > 0).any() else None
    if state.of("step"):
        first, _ = part.minimise(may, first)
        part = _stepped(frame, state, part, first)
    return valued(frame, state, may, first, v, part)


def _stepped(frame: Frame, state: State, part: Likelihood, theta: FloatArray) -> Likelihood:
    """Steps have known power above the lowest coefficients, once their sizes are known."""
    steps = state.of("step")
    eta, *_ = part.directions(theta)
    at = int(np.count_nonzero(~part.flat))
    size = eta[at : at + len(steps)]
    products = frame.remembered(
        steps, lambda: step_products(frame.spectrum, [p.shape[0] for p in steps])[:, frame.used]
    )
    known = np.outer(size, size).ravel() @ products
    return part.adding(np.broadcast_to(part.added, known.shape) + known)


def valued(  # noqa: PLR0917 - what a fit is made of
    frame: Frame, state: State, may: BoolArray, start: FloatArray | None, v: FloatArray, part: Likelihood, *,
    known: bool = False,
) -> Fitted:  # fmt: skip
    """A fit with its value; where there are resonances, with the best error of their shapes and the sizes beside it."""
    # `known` is whether `start` is the minimum at another error.
    loud = len(state.of("resonance"))
    least = part.settled(may, start, loud, SHAPE_ERRORS, known=known and loud > 0)
    theta, value = least.theta, least.value if loud else 2 * least.least
    trust = least.trust if loud else None
    if not math.isfinite(value):  # a shape leaves nothing where the record has power
        return Fitted(frame, state, may, theta, v, part, trust, least.completed[:4], math.inf)
    value += _volume(part, theta, frame, state)
    if state.filter is not None:
        value += frame.told(state.filter.label, state.filter.shape[0])[0]
    if v.size:
        value += float(v @ v) + _laplace(frame, state, part, theta, trust)
    return Fitted(frame, state, may, theta, v, part, trust, least.completed[:4], value)


def _laplace(frame: Frame, state: State, part: Likelihood, theta: FloatArray, trust: FloatArray | None) -> float:
    """Logarithm of the determinant of the information of v."""
    B, k = factor_basis(frame, state), sizes_inside(frame, state)
    h = (part.S[:, :k] @ theta[:k] / part.expectation(theta)) ** 2 * part.count / 2
    G = (B.T * (h if trust is None else h * trust)) @ B
    G.flat[:: G.shape[0] + 1] += 1
    return 2 * float(np.log(np.linalg.cholesky(G).diagonal()).sum())


def _volume(part: Likelihood, theta: FloatArray, frame: Frame, state: State) -> float:
    """From the integral over steps, a warm-up and a wave of any size, whose unit would count, to their best sizes."""
    # What every state has, a ramp and what a slow noise did during long gaps, stays integrated.
    if not any(map(state.of, DIRECTIONS)):
        return 0.0
    own = int(part.flat.sum() - frame.plain.flat.sum())
    if own <= 0:
        return 0.0
    V = part.directions(theta)[1][np.ix_(part.flat, part.flat)]
    volume = float(np.linalg.slogdet(V)[1] - np.linalg.slogdet(V[own:, own:])[1]) if np.isfinite(V).all() else math.inf
    return volume if math.isfinite(volume) else math.inf  # directions that the bins do not tell apart

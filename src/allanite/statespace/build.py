"""From a model whose terms are states to matrices, and their Allan variance; flicker by Gauss-Markov processes."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import UsageError
from allanite.core.model import Model, Term
from allanite.core.ranges import PART, TIME
from allanite.phrases.phrase import say
from allanite.terms import TERMS
from allanite.terms.markov import gauss_markov
from allanite.terms.powers import integrators
from allanite.terms.row import Block

PER_DECADE = 40  # averaging times at which the sum is compared with flicker
MOST = 40  # processes beyond which no ripple is requested
TOP = 1.892  # a process has the top of its Allan deviation at this multiple of its time constant


@dataclass(frozen=True, eq=False)
class MarkovSum:
    """Processes whose sum has the Allan variance of flicker with B = 1 between two averaging times."""

    # `time_constants` in s, RMS values `sizes` relative to B; `ripple` is the largest relative deviation from the Allan
    # deviation of flicker in the range.
    time_constants: FloatArray
    sizes: FloatArray
    ripple: float


def flicker_sum(tau: tuple[float, float], *, ripple: float = 0.02, order: int | None = None) -> MarkovSum:
    """The sum of Gauss-Markov processes that approximates flicker between two averaging times."""
    # Time constants are evenly spaced in the logarithm, over a span that is searched for; the powers are found by
    # non-negative least squares of the logarithm of the Allan variance, and scaled so that the sum errs as far upwards
    # as downwards.
    low, high = tau
    if not (low < high and TIME.holds(tau)):
        raise UsageError(f"a range of averaging times must be two numbers of s, 0 < low < high, not {low:g},{high:g}")
    if order is not None and not 1 <= order <= MOST:
        raise UsageError(f"the number of processes that approximate flicker must be between 1 and {MOST}, not "
                         f"{order!r}")  # fmt: skip
    PART.demand(ripple, "the ripple")
    for k in range(1, MOST + 1) if order is None else (order,):
        span = _best_span(low, high, k)
        if order is not None or span.ripple <= ripple:
            return span
    raise UsageError(f"{MOST} processes leave a ripple of {100 * span.ripple:.2g} % between {low:g} and {high:g} s; "
                     "allow a larger ripple, or use a shorter range")  # fmt: skip


def _best_span(low: float, high: float, k: int) -> MarkovSum:
    """The best of `k` processes: those at the ends may lie beyond the range, or within."""
    from scipy.optimize import minimize_scalar

    grid = np.geomspace(low, high, max(40, round(PER_DECADE * math.log10(high / low))))

    def fitted(beyond: float) -> MarkovSum:
        first, last = low / TOP * math.exp(-beyond), high / TOP * math.exp(beyond)
        T = np.geomspace(first, last, k) if k > 1 else np.array([math.sqrt(first * last)])
        from scipy.optimize import nnls

        columns = np.column_stack([allan_variance(grid, constant) for constant in T]) / TERMS["B"].level
        weight, power = np.ones(grid.size), np.zeros(T.size)
        for _ in range(12):
            power = nnls(columns * weight[:, None], weight)[0]
            ratio = columns @ power
            # the square of weight (ratio - 1) becomes that of ln(ratio)
            off = np.where(ratio == 1, 1.0, ratio - 1)
            weight = np.where(ratio == 1, 1.0, np.log(np.maximum(ratio, 1e-6)) / off)
        logs = np.log(columns @ power)
        middle = (logs.max() + logs.min()) / 2
        # of the deviation: half of the variance's
        return MarkovSum(T, np.sqrt(power * math.exp(-middle)), math.expm1((logs.max() - logs.min()) / 4))

    if k == 1:
        return fitted(0.0)
    # beyond the range a process helps little; within it, at most so far that the two ends meet
    limit = 0.45 * math.log(high / low)
    best = minimize_scalar(lambda x: fitted(float(x)).ripple, bounds=(-min(limit, 2.0), 2.0), method="bounded",
                           options={"xatol": 0.01})  # fmt: skip
    return fitted(float(best.x))


def allan_variance(tau: FloatArray, T: float) -> FloatArray:
    """For a Gauss-Markov process of RMS 1, ``(4 D(tau) - D(2 tau)) / (2 tau^2)``."""
    D = gauss_markov(1.0).structure
    u = tau / T
    return np.asarray((4 * D(u) - D(2 * u)) / (2 * u**2))


@dataclass(frozen=True, eq=False)
class StepMatrices:
    """Some steps together: x' = A x + w, sum of the outputs = c x + n, with the covariances of w and n."""

    A: FloatArray
    c: FloatArray
    Qww: FloatArray
    Qwn: FloatArray
    qnn: float

    def then(self, other: "StepMatrices") -> "StepMatrices":
        """These steps, and then those."""
        A, c = other.A, other.c
        return StepMatrices(A=A @ self.A, c=self.c + c @ self.A, Qww=A @ self.Qww @ A.T + other.Qww,
                            Qwn=A @ (self.Qww @ c + self.Qwn) + other.Qwn,
                            qnn=float(self.qnn + c @ self.Qww @ c + 2 * c @ self.Qwn + other.qnn))  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Matrices:
    """x' = Phi x + w, measurement = H x + v, cov(w) = Qd, var(v) = R, cov(x at start) = P0."""

    Phi: FloatArray
    Qd: FloatArray
    H: FloatArray
    R: FloatArray
    P0: FloatArray

    def allan(self, m: IntArray) -> FloatArray:
        """Allan variance of the measurements at averaging factors `m`, SI, exactly, shape of m."""
        # With the sums s_1 and s_2 of the measurements over m steps and the m steps after them, it is the variance of
        # s_2 - s_1 over 2 m^2, where s_2 - s_1 = c (A - 1) x + c w_1 + n_2 - n_1.
        h = self.H[0]
        noise = self.Qd @ h
        single = StepMatrices(self.Phi, h @ self.Phi, self.Qd, noise, float(h @ noise + self.R[0, 0]))
        powers = []
        for factor in m.tolist():
            # so many steps, by doubling
            steps, doubled, remaining = None, single, factor
            while remaining:
                if remaining & 1:
                    steps = doubled if steps is None else steps.then(doubled)
                remaining >>= 1
                doubled = doubled.then(doubled) if remaining else doubled
            assert steps is not None  # noqa: S101 - the factor is at least 1
            start = steps.c @ (steps.A - np.eye(len(self.P0)))
            variance = start @ self.P0 @ start + steps.c @ steps.Qww @ steps.c - 2 * steps.c @ steps.Qwn + 2 * steps.qnn
            powers.append(variance / (2 * factor**2))
        return np.array(powers)


def equivalent(model: Model, fitted: MarkovSum | None) -> Model:
    """The model with flicker replaced."""
    terms: list[Term] = []
    for t in model:
        if not t.row.substitute or fitted is None:
            terms.append(t)
            continue
        pairs = zip(fitted.sizes.tolist(), fitted.time_constants.tolist(), strict=True)
        terms += [Term(t.row.substitute, t.value * size, t.signal, (T,)) for size, T in pairs if size > 0]
    return Model(tuple(terms))


def blocks_of(model: Model, h: float) -> list[Block]:
    """The terms as states, in the order of `TERMS`; a term without states is a UsageError."""
    known, blocks = list(TERMS), []
    for t in sorted(model, key=lambda t: known.index(t.symbol)):
        if t.row.block is None:
            able = ", ".join(symbol for symbol, row in TERMS.items() if row.block or row.substitute)
            raise UsageError(f"{t.symbol} ({t.row.title}) has no states in a filter, {able} have: omit it "
                             "from the model, or replace it by a term with a similar curve at the relevant averaging "
                             "times")  # fmt: skip
        blocks.append(t.row.block(t.value, t.shape, h))
    return blocks


def states_of(blocks: list[Block], turn_on: float, h: float) -> list[Block]:
    """The blocks that have states, those of continuous time first; with a bias of standard deviation `turn_on`."""
    bias = [block for block in blocks if block.bias]
    bias += [integrators((say("bias"),), h, start=turn_on)] if turn_on else []
    others = [block for block in blocks if block.names and not block.bias]
    others.sort(key=lambda block: not block.output.any())
    return ([joined(bias)] if bias else []) + others


def joined(blocks: Sequence[Block]) -> Block:
    """One block of the bias and its derivatives in place of several; those that add nothing leave no name."""
    longest = max(blocks, key=lambda block: len(block.names))
    s = len(longest.names)
    names, Qc, P0, Q = list(longest.names), np.zeros((s, s)), np.zeros((s, s)), np.zeros((s + 1, s + 1))
    for block in blocks:
        k = len(block.names)
        at = np.append(np.arange(k), s)
        Qc[:k, :k] += block.Qc
        P0[:k, :k] += block.P0
        Q[np.ix_(at, at)] += block.Q
        if block.Qc.any():
            names[k - 1] = block.names[-1]
    return replace(longest, names=tuple(names), Qc=Qc, P0=P0, Q=Q)


def sampled(blocks: list[Block], R: FloatArray) -> Matrices:
    """A measurement is the rate at the time of the states."""
    from scipy.linalg import block_diag

    Phi, P0 = (block_diag(*(getattr(b, name) for b in blocks)) for name in ("Phi", "P0"))
    Qd = block_diag(*(b.Q[:-1, :-1] for b in blocks))
    return Matrices(Phi, Qd, np.concatenate([b.output for b in blocks])[None, :], R, P0)


def averaged(blocks: list[Block], R: FloatArray) -> Matrices:
    """The mean over the interval is the last state, and the measurement."""
    inner = sampled(blocks, R)
    s = len(inner.Phi)
    Phi, Qd, P0 = (np.zeros((s + 1, s + 1)) for _ in range(3))
    Phi[:s, :s], Qd[:s, :s], P0[:s, :s] = inner.Phi, inner.Qd, inner.P0
    Phi[s, :s] = np.concatenate([b.mean for b in blocks])
    Qd[:s, s] = Qd[s, :s] = np.concatenate([b.Q[:-1, -1] for b in blocks])
    Qd[s, s] = sum(b.Q[-1, -1] for b in blocks)
    P0[s, s] = float(Phi[s, :s] @ inner.P0 @ Phi[s, :s] + Qd[s, s])
    return Matrices(Phi, Qd, np.eye(s + 1)[None, -1], R, P0)


@dataclass(frozen=True)
class Measurement:
    """What a measurement is taken for, and how the matrices are built."""

    meaning: str
    build: Callable[[list[Block], FloatArray], Matrices]


MEASUREMENTS: dict[str, Measurement] = {
    "mean": Measurement(say("a measurement is the mean rate over the interval that ends at the time of the states; the "
                            "mean is a state, exact"), averaged),
    "sample": Measurement(say("a measurement is the rate at the time of the states, used instead of the mean over the "
                              "interval that ends there"), sampled),
}  # fmt: skip


def continuous(blocks: list[Block]) -> tuple[FloatArray, FloatArray]:
    """F and Qc of the states that exist in continuous time."""
    from scipy.linalg import block_diag

    inner = [b for b in blocks if b.output.any()]
    F, Qc = (block_diag(*(getattr(b, name) for b in inner)) if inner else np.zeros((0, 0)) for name in ("F", "Qc"))
    return F, Qc

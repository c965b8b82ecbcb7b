"""Steps of the bias, whose spectrum is that of a random walk.

A few steps add power that falls as f^-2 with frequency, and K describes them well; but K is then no property of the
noise, and the record between the steps has none of it. In the likelihood steps are directions of any size, like a
ramp; their places are searched for one after the other.
"""

from dataclasses import dataclass, replace

import numpy as np

from allanite.core.arrays import FloatArray
from allanite.core.finding import Finding
from allanite.core.plain import Portable
from allanite.core.units import Signal, convert
from allanite.phrases.phrase import join, say
from allanite.phrases.wording import longest_without
from allanite.terms import TERMS, WHITE

from .bins import SINGLE
from .model_selection import Found
from .selection import PENALTY, Subset
from .warmup import WarmUp
from .whittle import step_coefficients, step_power, with_steps

PLACES = 512
"""Places in the record at which steps are looked for."""

FINE = 63
"""Places between the two beside one of these, of which the best is taken."""

EVIDENCE = 12.0
"""What each step must gain in 2 L: for its size and its place."""

CLEAR = 8.0
"""What steps must gain in 2 L beyond the random walk."""

MOST = 10
"""Steps, at most: more are a random walk."""


@dataclass(frozen=True, eq=False)
class BiasSteps(Portable):
    """Steps of the bias: times, s, and sizes with their standard errors, SI; beginning and end of the record, s."""

    signal: Signal
    time: FloatArray
    size: FloatArray
    error: FloatArray
    span: tuple[float, float]

    @property
    def finding(self) -> Finding:
        """The finding about them."""
        unit = self.signal.sheet[0]
        each = [
            say("{size:+.3g} {unit} at {time:.4g} s", size=convert(float(size), self.signal.unit, unit), unit=unit,
                time=time)
            for time, size in zip(self.time, self.size, strict=True)
        ]  # fmt: skip
        apart = (self.span[1] - self.span[0]) / PLACES  # a low step is placed less well
        return Finding(
            "steps",
            say("the bias steps: {steps}", steps=join(", ", each)),
            say("they explain the record better than a random walk does, and K is no property of the noise"),
            say(
                "analyze the parts between the steps ({choice})",
                choice=longest_without(zip(self.time - apart, self.time + apart, strict=True), self.span),
            ),
            (float(self.time[0]), float(self.time[0])),
        )


def steps_in(found: Found, signal: Signal, warm: WarmUp | None = None) -> BiasSteps | None:
    """The steps that explain a record better than its random walk, or a warm-up of it, does; None if there is none."""
    seen, chosen = found.seen, found.chosen
    walk = np.array([TERMS[s].slope > 0 for s in found.noise] + [False] * (chosen.theta.size - len(found.noise)))
    wandering = (walk & (chosen.theta > 0)).any()
    if not (wandering or warm) or seen.pieces is not None or seen.gaps.at.size or not found.used[:SINGLE].all():
        return None
    # the white noise, which is always there
    white = [TERMS[s].slope == WHITE for s in found.noise]
    base = replace(chosen, free=chosen.free & ~walk | np.array(white + [False] * (chosen.theta.size - len(white))))
    goal = chosen.profiled + PENALTY * float((chosen.free & walk).sum()) - CLEAR
    if warm:
        more = float(warm.base.free.sum() - base.free.sum()) + 2 * float(len(warm.base.constants) - len(base.constants))
        goal = min(goal, warm.at(warm.tau)[0] + PENALTY * more + EVIDENCE - CLEAR)
    at: list[float] = []
    beside = _beside(found, base, at)
    for _ in range(MOST):
        at.append(_place(found, beside, at))
        beside = _beside(found, base, at)
        if beside.profiled + EVIDENCE * len(at) < goal:
            size, error = (found.seen.unit_factor * each for each in _sizes(beside, len(at)))
            span = seen.cut, seen.cut + seen.size / seen.rate
            return BiasSteps(signal, seen.cut + np.array(sorted(at)) / seen.rate, size, error, span)
    return None


def _beside(found: Found, base: Subset, at: list[float]) -> Subset:
    """What the terms explain beside steps: those of the lowest bins directions, those of the bins above known power."""
    part, places = base.likelihood, sorted(at)
    if not places:
        return Subset(part, base.free, *part.minimise(base.free), base.constants)
    part = with_steps(part, found.seen, found.used, places)
    lowest = Subset(part, base.free, *part.minimise(base.free), base.constants)
    power = step_power(found.seen, places, _sizes(lowest, len(places))[0])
    part = replace(part, added=part.added + power[found.used])
    return Subset(part, base.free, *part.minimise(base.free), base.constants)


def _sizes(beside: Subset, count: int) -> tuple[FloatArray, FloatArray]:
    """Sizes of the steps and their standard errors, in the unit of the spectrum."""
    eta, V, _ = beside.likelihood.directions(beside.theta)
    here = slice(first := int(np.count_nonzero(~beside.likelihood.flat)), first + count)
    return eta[here], np.sqrt(np.diag(V)[here])


def _place(found: Found, beside: Subset, at: list[float]) -> float:
    """Where one more step gains most, beside those there are and a ramp, for the power that the terms have."""
    seen, k = found.seen, min(SINGLE, found.seen.first.size)
    c, m = (seen.even + seen.odd)[:k], beside.likelihood.expectation(beside.theta)[:k]
    others = [step_coefficients(seen.size, j)[:k] for j in at] + [seen.ramp[:k]]
    Q = np.linalg.qr(np.array(others).T / np.sqrt(m)[:, None])[0]
    apart, y = seen.size / (PLACES + 1), c / np.sqrt(m)
    places = apart * np.arange(1, PLACES + 1)
    for _ in range(2):  # and then between the neighbors of the best, which the place of a high step needs
        D = step_coefficients(seen.size, places)[:, :k] / np.sqrt(m)
        D -= D @ Q @ Q.T
        best = places[int(((D @ y) ** 2 / np.maximum((D**2).sum(axis=1), 1e-9)).argmax())]
        places = best + apart * np.linspace(-1, 1, FINE)[1:-1]
    return float(best)

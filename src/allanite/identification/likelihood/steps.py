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
from allanite.phrases.wording import windowing
from allanite.terms import TERMS, WHITE

from .bins import SINGLE
from .model_selection import Found
from .selection import PENALTY, Subset
from .whittle import step_coefficients, with_steps

PLACES = 512
"""Places in the record at which steps are looked for."""

EVIDENCE = 12.0
"""What each step must gain in 2 L: for its size and its place."""

CLEAR = 8.0
"""What steps must gain in 2 L beyond the random walk."""

MOST = 10
"""Steps, at most: more are a random walk."""


@dataclass(frozen=True, eq=False)
class BiasSteps(Portable):
    """Steps of the bias: times, s, and sizes with their standard errors, SI."""

    signal: Signal
    time: FloatArray
    size: FloatArray
    error: FloatArray

    @property
    def finding(self) -> Finding:
        """The finding about them."""
        unit = self.signal.sheet[0]
        each = [
            say("{size:+.3g} {unit} at {time:.4g} s", size=convert(float(size), self.signal.unit, unit), unit=unit,
                time=time)
            for time, size in zip(self.time, self.size, strict=True)
        ]  # fmt: skip
        return Finding(
            "steps",
            say("the bias steps: {steps}", steps=join(", ", each)),
            say("they explain the record better than a random walk does, and K is no property of the noise"),
            say("analyze the parts between the steps ({choice})", choice=windowing()),
            (float(self.time[0]), float(self.time[0])),
        )


def steps_in(found: Found, signal: Signal) -> BiasSteps | None:
    """The steps that explain a record better than its random walk does; None if there is none."""
    seen, chosen = found.seen, found.chosen
    walk = np.array([TERMS[s].slope > 0 for s in found.noise] + [False] * (chosen.theta.size - len(found.noise)))
    wandering = (walk & (chosen.theta > 0)).any()
    if not wandering or seen.pieces is not None or seen.gaps.at.size or not found.used[:SINGLE].all():
        return None
    # the white noise, which is always there
    white = [TERMS[s].slope == WHITE for s in found.noise]
    base = replace(chosen, free=chosen.free & ~walk | np.array(white + [False] * (chosen.theta.size - len(white))))
    goal = chosen.profiled + PENALTY * float((chosen.free & walk).sum()) - CLEAR
    at: list[float] = []
    beside = _beside(found, base, at)
    for _ in range(MOST):
        at.append(_place(found, beside, at))
        beside = _beside(found, base, at)
        if beside.profiled + EVIDENCE * len(at) < goal:
            seen, first = found.seen, int(np.count_nonzero(~beside.likelihood.flat))
            eta, V, _ = beside.likelihood.directions(beside.theta)
            here = slice(first, first + len(at))
            size, error = eta[here] * seen.unit_factor, np.sqrt(np.diag(V)[here]) * seen.unit_factor
            return BiasSteps(signal, np.array(sorted(at)) / seen.rate, size, error)
    return None


def _beside(found: Found, base: Subset, at: list[float]) -> Subset:
    part = with_steps(base.likelihood, found.seen, found.used, sorted(at)) if at else base.likelihood
    return Subset(part, base.free, *part.minimise(base.free), base.constants)


def _place(found: Found, beside: Subset, at: list[float]) -> float:
    """Where one more step gains most, beside those there are and a ramp, for the power that the terms have."""
    seen, k = found.seen, min(SINGLE, found.seen.first.size)
    c, m = (seen.even + seen.odd)[:k], beside.likelihood.expectation(beside.theta)[:k]
    others = [step_coefficients(seen.size, j)[:k] for j in at] + [seen.ramp[:k]]
    Q = np.linalg.qr(np.array(others).T / np.sqrt(m)[:, None])[0]
    places = np.linspace(0, seen.size, PLACES + 2)[1:-1]
    D = np.array([step_coefficients(seen.size, j)[:k] for j in places]).T / np.sqrt(m)[:, None]
    D -= Q @ (Q.T @ D)
    y = c / np.sqrt(m)
    gain = (D.T @ y) ** 2 / np.maximum((D**2).sum(axis=0), 1e-9)
    return float(places[int(gain.argmax())])

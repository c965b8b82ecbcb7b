"""Is the Cramer-Rao bound that of a Gaussian record: against full matrices, with and without an unknown ramp.

The referee makes the covariance of the differences of the rates, and the information tr(P C_i P C_j) / 2 from it.
Nothing is random: there is no seed.
"""

from table import begin, markdown

import math

import numpy as np
from scipy.linalg import cho_factor, cho_solve, toeplitz

import allanite as al

MODELS = {
    **al.planning.SENSORS,
    "N B K": "N 1 rad/sqrt(s), B 0.3 rad/s, K 0.1 rad/s^1.5",
    "Q N": "Q 1 rad, N 0.1 rad/sqrt(s)",
    "Q K": "Q 1 rad, K 0.01 rad/s^1.5",
    "N GM K": "N 1 rad/sqrt(s), GM 1 rad/s 5 s, K 0.01 rad/s^1.5",
}
HEADINGS = ("model", "rate, Hz", "ramp", "parameter", "full matrices, %", "bound, %", "ratio")


def dense(model: al.Model, n: int, rate: float, ramp: bool) -> tuple[np.ndarray, float]:
    """Relative errors of coefficients and time constants, and the standard error of the ramp, from full matrices."""

    def covariance(t: al.Term) -> np.ndarray:
        return t.power(rate) * toeplitz(t.sampled(rate).increments(np.arange(n - 1.0)))

    parts, noise = [], [t for t in model if t.row.waveform is None]
    for t in noise:
        parts.append(covariance(t))
        for T in t.shape:
            up, down = (covariance(al.Term(t.symbol, t.value, t.signal, (T * f,))) for f in (1.001, 1 / 1.001))
            parts.append((up - down) / (4 * math.log(1.001)))
    C = sum(covariance(t) for t in noise)
    scale = C.max()
    factor, ones = cho_factor(C / scale), np.ones(n - 1)
    solved, u = [cho_solve(factor, part / scale) for part in parts], cho_solve(factor, ones)
    if ramp:
        solved = [W - np.outer(u, ones @ W) / (ones @ u) for W in solved]
    F = np.array([[np.sum(A * B.T) / 2 for B in solved] for A in solved])
    return np.sqrt(np.diag(np.linalg.inv(F))) / 2, math.sqrt(scale / (ones @ u)) * rate


def made(name: str, n: int, rate: float, *, ramp: bool) -> list[tuple[str, ...]]:
    """The rows of a model; a ramp's error is shown for one of 1e-6 rad/s^2."""
    model = al.Model(MODELS[name])
    noise = al.Model(tuple(t for t in model if t.row.waveform is None))
    errors, slope = dense(noise, n, rate, ramp)
    found = al.bound(noise, n, rate, ramp=ramp)
    pairs = list(zip(found.names, errors, found.errors, strict=True))
    if ramp:
        pairs.append(("R", slope / 1e-6, (found.ramp or math.nan) / 1e-6))
    head = (name, f"{rate:g}", "unknown" if ramp else "none")
    return [(*head, parameter, f"{100 * a:.4g}", f"{100 * b:.4g}", f"{b / a:.4f}") for parameter, a, b in pairs]


def main() -> None:
    run = begin(__doc__, size=2048)
    size = run.asked.size
    rates = {name: (1.0, 100.0) if name in al.planning.SENSORS else (1.0,) for name in MODELS}
    cases = [(name, rate, ramp) for name in MODELS for rate in rates[name] for ramp in (False, True)]
    rows = [row for name, rate, ramp in cases for row in made(name, size, rate, ramp=ramp)]
    notes = [
        "nothing is random, there is no seed",
        f"{size} readings; relative standard errors (1 sigma); the largest deviation of a ratio from 1 is "
        f"{max(abs(float(row[-1]) - 1) for row in rows):.4f}",
    ]
    run.publish("The Cramer-Rao bound against full matrices", notes, markdown(HEADINGS, rows))


if __name__ == "__main__":
    main()

"""How often a regression sees effects that are not there, holds the truth, and gains what it promises.

Rates of 1 Hz over 1 h from the independent simulator, with the noise of table 2 of the paper on the magnetically
suspended gyro (N 2.525648 deg/sqrt(h), B 12.023988 deg/h, K 32.72457 deg/h/sqrt(h)) or with other noise; a thermometer
of 0.0625 degC steps that drifts in one of three ways.
"""

from table import SEEDS, begin, coefficients, markdown, seeded, spread

from functools import partial

import numpy as np

import allanite as al
from allanite.applications.compensation import FitSettings, compensate, gain_on
from allanite.applications.compensation.regressor import local_slope
from allanite.core.units import convert
from judge import sensor

N, B, K = al.N(2.525648, "deg/sqrt(h)"), al.B(12.023988, "deg/h"), al.K(32.72457, "deg/h/sqrt(h)")
NOISE = {
    "table 2": N + B + K, "no walk": N + B, "fourfold flicker": N + al.B(48.0, "deg/h"),
    "threefold walk": al.Q(30.0, "arcsec") + N + B + al.K(100.0, "deg/h/sqrt(h)"), "no flicker": N + K,
    "white": al.Model((N,)),
}  # fmt: skip
SIZE, STEP = 3600, 0.0625
RATE = convert(1.0, "deg/h", "rad/s")
EFFECTS = {"temp": 20.0 * RATE, "d temp/dt": 2000.0 * RATE}  # rate per degC, and per degC/s
FIT = FitSettings(least=1.0)  # one record of some hundreds would be refused, for too few effective samples
gyro = partial(al.Record, rate=1.0, unit="rad/s", name="gyro")
compensated = partial(compensate, regressors=["temp"], derivative_of=["temp"], settings=FIT)

HEADINGS = (
    "noise", "temperature", "regressor", "false %", "ordinary %", "within 95 % limits", "gain met %",
)  # fmt: skip


CELLS = [
    *(("table 2", drift) for drift in ("walk", "warming", "cycle")),
    *((noise, drift) for noise in list(NOISE)[1:] for drift in ("walk", "warming")),
]
"""Which noise, and how the temperature drifts."""


def temperature(drift: str, rng: np.random.Generator) -> np.ndarray:
    """Readings of a thermometer, degC."""
    t = np.arange(SIZE) / SIZE
    true = {
        "walk": lambda: np.cumsum(rng.standard_normal(SIZE)) * 0.02,
        "warming": lambda: 15 * (1 - np.exp(-t / 0.4)) + 0.3 * np.sin(2 * np.pi * (2.3 * t + rng.uniform())),
        "cycle": lambda: 3 * np.sin(2 * np.pi * (1.7 * t + rng.uniform())),
    }[drift]()
    return 25 + STEP * np.round((true + 0.03 * rng.standard_normal(SIZE)) / STEP)


def recording(noise: str, drift: str, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, al.Recording]:
    """Samples of a gyro without an effect, the columns of its regressors, and its thermometer."""
    temp = al.Record(temperature(drift, rng), 1.0, "degC", name="temp")
    X = np.column_stack([temp.values - 25, local_slope(temp.values, 1.0, 60.0)])
    return sensor(SIZE, 1.0, rng, **coefficients(NOISE[noise])), X, al.Recording((temp,))


def affected(noise: str, drift: str, rng: np.random.Generator) -> tuple[al.Record, al.Recording]:
    """A gyro that depends on its temperature, and its thermometer."""
    y, X, along = recording(noise, drift, rng)
    return gyro(y + X @ list(EFFECTS.values())), along


def ordinary(y: np.ndarray, X: np.ndarray) -> np.ndarray:
    """T of ordinary least squares with a constant."""
    X = np.column_stack([X, np.ones(y.size)])
    inverse = np.linalg.inv(X.T @ X)
    beta = inverse @ X.T @ y
    variance = ((y - X @ beta) ** 2).sum() / (y.size - X.shape[1])
    return (beta / np.sqrt(variance * np.diag(inverse)))[:-1]


def measured(job: tuple[str, str, int]) -> np.ndarray:
    """For both regressors: false effects by two ways, within limits; and whether the gain elsewhere is met."""
    *cell, number = job
    rng = seeded(number, *cell)
    y, X, along = recording(*cell, rng)
    plain = compensated(gyro(y), along)
    false, worse = [plain[label].p < 0.05 for label in EFFECTS], np.abs(ordinary(y, X)) > 1.96
    found = compensated(*affected(*cell, rng))
    within = [found[label].low < size < found[label].high for label, size in EFFECTS.items()]
    gain = gain_on(found, *affected(*cell, rng))
    return 100.0 * np.array([false, worse, within, [gain.met] * 2])


def main() -> None:
    run = begin(__doc__, records=400)
    records, rows = run.asked.records, []
    for cell, results in spread(measured, CELLS, records):
        for label, shares in zip(EFFECTS, np.mean(results, axis=0).T, strict=True):
            rows.append((*cell, label, *(f"{share:.1f}" for share in shares)))
    notes = [
        f"{SEEDS}; {records} records a cell, 1 Hz, 1 h; Monte-Carlo standard error at 5 %: "
        f"{100 * (0.05 * 0.95 / records) ** 0.5:.1f} %",
        "false: no dependence, and an effect at 5 %; ordinary: by ordinary least squares",
        "within 95 % limits: a simulated effect of 20 deg/h/degC and 2000 deg/h/(degC/s); gain met: another record of "
        "the same effects, temperature and noise, whose mean square fell by what was promised, within 95 % limits",
    ]
    run.publish("Compensation by regressors", notes, markdown(HEADINGS, rows))


if __name__ == "__main__":
    main()

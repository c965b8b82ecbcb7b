"""The gyro-vertical: closed forms, predicted against simulated errors, filters in scenarios.

Errors are made of the noise of the independent simulator; the scenarios are those of the package, with seed 1.
"""

from table import SEEDS, Row, begin, coefficients, section, seeded, spread

import math
from collections.abc import Sequence
from functools import cache
from itertools import chain, product

import numpy as np
from scipy.signal import lfilter

import allanite as al
from allanite.applications.attitude import ScenarioErrors, Trial, kalman, optimal_time_constant
from allanite.applications.attitude.loop import GRAVITY
from judge import sensor

ARCSEC = math.pi / 648_000
HOUR = math.pi / 180 / 3600
GYRO, TILT = "N 0.3 deg/sqrt(h)", "N 100 ug/sqrt(Hz)"
WHOLE = (f"{GYRO}, B 10 deg/h, K 20 deg/h/sqrt(h)", f"{TILT}, B 50 ug")
MODELS = (
    (GYRO, TILT), ("N 3 deg/sqrt(h)", TILT), ("N 0.03 deg/sqrt(h)", TILT), (f"{GYRO}, B 10 deg/h", TILT),
    (f"{GYRO}, B 100 deg/h", TILT), (f"{GYRO}, K 20 deg/h/sqrt(h)", TILT), (f"{GYRO}, K 500 deg/h/sqrt(h)", TILT),
    (f"{GYRO}, Q 5 arcsec", TILT), (f"{GYRO}, GM 30 deg/h 5 s", TILT), (f"{GYRO}, GM 100 deg/h 50 s", TILT),
    (GYRO, f"{TILT}, B 50 ug"), (GYRO, f"{TILT}, B 500 ug"), (GYRO, f"{TILT}, K 500 ug/sqrt(h)"),
    (GYRO, f"{TILT}, Q 1e-4 m/s"), (GYRO, f"{TILT}, GM 200 ug 2 s"), (GYRO, "N 1000 ug/sqrt(Hz), GM 2000 ug 0.5 s"),
    WHOLE, ("N 0.01 deg/sqrt(h), B 0.1 deg/h", "N 20 ug/sqrt(Hz), B 10 ug"),
    ("GM 0.02 deg/s 5 s", "GM 0.0087266 g 0.5 s"),
    ("Q 2 arcsec, N 2 deg/sqrt(h), B 30 deg/h, K 200 deg/h/sqrt(h)", "N 300 ug/sqrt(Hz), B 300 ug, K 100 ug/sqrt(h)"),
)  # fmt: skip
TIMES = (0.5, 2.0, 8.0)
RATE, HORIZON, LONGER = 10.0, 100.0, 4
"""Sampling rate, Hz, and T, s, of predicted against simulated errors; a run has so many T."""
WHOLE_RATE = 20.0
QUOTED = {600.0: "0.762 s, 26.3", 3600.0: "0.691 s, 28.3"}
"""Duration, s, and what an independent program gives for the best time constant and its error, arcsec."""
SCENARIO_FIGURES = {
    "accelerometer": (0.0573, 2.378, 0.838), "bortz": (0.975, 0.906, 0.843), "first order, 1 s": (0.0058, 2.286, 0.507),
    "first order, 10 s": (0.0279, 1.465, 0.0439), "first order, 100 s": (0.2462, 0.328, 0.215),
    "second order, 100 s, 500 s": (0.226, 0.318, 0.196), "madgwick, beta 0.033": (0.0313, 2.300, 0.838),
    "madgwick, beta 0.001": (0.0064, 0.555, 0.0521), "mahony, 50 s": (0.123, 0.467, 0.108),
}  # fmt: skip
"""RMS, deg, of an independent prototype; its gyros read the rate at the end of each interval."""
BIAS = (10 * HOUR, -7 * HOUR, 5 * HOUR)
FIRST_ORDER = {"first order, 1 s": 1.0, "first order, 10 s": 10.0, "first order, 100 s": 100.0}
SWAY = ((math.radians(8.0), 0.12), (math.radians(10.0), 0.2))
"""Amplitude, rad, and frequency, Hz, of roll and pitch in the oscillation."""
LEVER = 1.0


def errors(models: Sequence[str], tau: float, size: int, rate: float, rng: np.random.Generator) -> np.ndarray:
    """Errors of one angle in a run that has settled, rad, by the recursion of the filter of first order."""
    settle = round(10 * tau * rate)
    gyro, tilt = (sensor(size + settle, rate, rng, **coefficients(al.Model(text))) for text in models)
    alpha = math.exp(-1 / (rate * tau))
    return lfilter([1.0], [1.0, -alpha], alpha * gyro / rate + (1 - alpha) * tilt / GRAVITY)[settle:]


def within(error: np.ndarray, rate: float, lowest: float) -> float:
    """Variance of a series above a frequency; the line between its ends is taken off."""
    n = len(error)
    power = np.abs(np.fft.rfft(error - np.linspace(error[0], error[-1], n))) ** 2 * 2 / n**2
    f = np.fft.rfftfreq(n, 1 / rate)
    power[-1] /= 2
    return float(power[f > lowest * 1.0001].sum() + power[np.isclose(f, lowest)].sum() / 2)


def square(job: tuple[str, str, float, int]) -> float:
    """Mean square of the errors of a run over the horizon, rad^2."""
    *models, tau, number = job
    size = round(LONGER * HORIZON * RATE)
    return within(errors(models, tau, size, RATE, seeded(number, *models, tau)), RATE, 1 / (2 * HORIZON))


def whole(job: tuple[float, float, int]) -> float:
    """Mean square of the errors about their mean in a run of so many s, of flicker and random walk together, rad^2."""
    duration, tau, number = job
    return float(errors(WHOLE, tau, round(duration * WHOLE_RATE), WHOLE_RATE, seeded(number, "whole", duration)).var())


def predicted(models: Sequence[str], tau: float, duration: float, rate: float) -> float:
    """Standard deviation, arcsec."""
    return al.attitude.predicted_error(*map(al.Model, models), tau, duration=duration, rate=rate).to("arcsec")


def rms(squares: list[float]) -> float:
    """Of runs, arcsec."""
    return math.sqrt(np.mean(squares)) / ARCSEC


def kalman_error(N: float, tilt: float, K: float = 0.0) -> float:
    """Standard deviation of the angle of the steady Kalman filter, rad."""
    return math.sqrt(tilt * math.sqrt(N**2 + 2 * K * tilt))


def closed_forms() -> list[Row]:
    """What is derived on paper beside what the package computes."""
    gyro, tilt = al.Model(GYRO), al.Model(TILT)
    N, K, a = gyro["N"].value, 20 * HOUR / 60, 1e-4
    best, loop = optimal_time_constant(gyro, tilt), kalman(N, a, K)
    biased = optimal_time_constant(gyro, tilt, gyro_bias="10 deg/h")
    slow = optimal_time_constant(al.Model("GM 0.02 deg/s 5 s"), al.Model("GM 0.0087266 g 0.5 s"))
    detuned = ", ".join(f"{rms / ARCSEC:.2f}" for k, rms in best.detuning if k != 1)
    return [
        ("best time constant, s", f"{best.time_constant:.4f}", "1.1459"),
        ("error there, arcsec", f"{best.first.to('arcsec'):.2f}", "19.27"),
        ("detuned by 1/4, 1/2, 2, 4, arcsec", detuned, "28.09, 21.54, 21.54, 28.09"),
        ("gains of second order, 1/s and 1/s^2", f"{loop.k1:.5f}, {-loop.k2:.6f}", "0.89099, -0.016160"),
        ("error of second order, arcsec", f"{kalman_error(N, a, K) / ARCSEC:.3f}", "19.470"),
        ("with a bias of 10 deg/h: s, arcsec", f"{biased.time_constant:.3f}, {biased.first.to('arcsec'):.2f}",
         "0.810, 21.43"),
        ("Gauss-Markov: s, deg", f"{slow.time_constant:.2f}, {slow.first.to('deg'):.4f}", "8.06, 0.1567"),
    ]  # fmt: skip


def losses() -> list[Row]:
    """A line for each pair of models."""
    rows = []
    for models in MODELS:
        found = optimal_time_constant(*map(al.Model, models), duration=600.0, rate=100.0)
        cells = f"{found.first.to('arcsec'):.2f}", f"{found.bound / ARCSEC:.2f}", f"{100 * found.loss:.2f} %"
        rows.append((*models, f"{found.time_constant:.3g}", *cells))
    return rows


def swaying(tau: float, *, instant: bool, rate: float = 100.0) -> float:
    """RMS error of a filter of first order in the oscillation, rad, without noise and biases, in closed form.

    The lever makes the accelerometers read w^2 LEVER / g of the angle too much, and a rate that is read at the end of
    its interval makes the integrated angle lead by half of it; the error is the angle times
    w^2 (LEVER / g - tau dt / 2) / (1 + j w tau).
    """
    arm = LEVER / GRAVITY - (tau / (2 * rate) if instant else 0.0)
    squares = [(A * w**2 * arm) ** 2 / (1 + (w * tau) ** 2) / 2 for A, w in ((A, 2 * math.pi * f) for A, f in SWAY)]
    return math.sqrt(sum(squares) / 2)


@cache
def scenarios() -> tuple[ScenarioErrors, ...]:
    """Filters in all scenarios: with mean rates, and with rates at the end of each interval."""
    trials = (Trial(al.Model(GYRO), al.Model(TILT), BIAS, instant=how) for how in (False, True))  # of the prototype
    return tuple(al.attitude.compare_filters(trial, rng=np.random.default_rng(1)) for trial in trials)


def scenario_rows() -> list[Row]:
    """A line for each filter."""
    rows = []
    for i, name in enumerate(scenarios()[0].filters):
        own = np.degrees([made.rms[i] for made in scenarios()]).T
        known = [f"{figure:.4f}" for figure in SCENARIO_FIGURES.get(name, ())] or ["-"] * 3
        cells = ((*(f"{rms:.4f}" for rms in pair), figure) for pair, figure in zip(own, known, strict=True))
        rows.append((name, *chain.from_iterable(cells)))
    return rows


def oscillation_rows() -> list[Row]:
    """The closed form, with the error at rest added, beside the simulation: mean rates, then instant ones."""
    rows = []
    for name, tau in FIRST_ORDER.items():
        cells = []
        for how, made in zip((False, True), scenarios(), strict=True):
            rest, _, own = np.degrees(made.rms[made.filters.index(name)])
            cells += [math.hypot(rest, math.degrees(swaying(tau, instant=how))), own]
        rows.append((name, *(f"{cell:.4f}" for cell in (*cells, SCENARIO_FIGURES[name][2]))))
    return rows


def flicker_rows(runs: int) -> list[Row]:
    """A line for each duration, at its best time constant."""
    best = [(T, optimal_time_constant(*map(al.Model, WHOLE), duration=T).time_constant) for T in QUOTED]
    return [
        (f"{T:g}", f"{tau:.4g}", f"{predicted(WHOLE, tau, T, WHOLE_RATE):.4g}", f"{rms(squares):.4g}", QUOTED[T])
        for (T, tau), squares in spread(whole, best, runs)
    ]


def compared_rows(runs: int) -> list[Row]:
    """A line for each pair of models and time constant."""
    rows = []
    for (*models, tau), squares in spread(square, [(*m, tau) for m, tau in product(MODELS, TIMES)], runs):
        a, b = predicted(models, tau, HORIZON, RATE), rms(squares)
        rows.append((*models, f"{tau:g}", f"{a:.2f}", f"{b:.2f}", f"{100 * (b / a - 1):+.2f} %"))
    return rows


PAIR, WAYS = ("gyro", "accelerometer", "time constant [s]"), ("mean", "instant", "expected")


def main() -> None:
    run = begin(__doc__, runs=150, whole=40)
    runs = run.asked.runs
    scenes = [f"{place} {how}" for place in ("fixed base", "acceleration", "oscillation") for how in WAYS]
    sections = (
        ("Closed forms", ("what", "here", "expected"), closed_forms()),
        ("Flicker and random walk",
         ("T [s]", "time constant [s]", "predicted [arcsec]", "simulated [arcsec]", "expected"),
         flicker_rows(run.asked.whole), f"{WHOLE[0]}; {WHOLE[1]}; {run.asked.whole} runs."),
        ("Predicted against simulated", (*PAIR, "predicted", "simulated", "difference"), compared_rows(runs),
         f"Above 1/(2T), T = {HORIZON:g} s, {RATE:g} Hz, {runs} runs of {LONGER} T; arcsec."),
        ("Loss against the optimal causal filter", (*PAIR, "first order", "bound", "loss"), losses(),
         "T = 600 s, 100 Hz; arcsec."),
        ("Scenarios", ("filter", *scenes), scenario_rows(),
         "RMS of roll and pitch, deg: with mean rates, with rates at the end of each interval, and of an independent "
         "prototype with these."),
        ("Oscillation in closed form",
         ("filter", "mean derived", "mean simulated", "instant derived", "instant simulated", "expected"),
         oscillation_rows(), "RMS of roll and pitch, deg: lever arm and lead of the sampled rates in closed form, with "
         "the error at rest; simulated; and of the prototype."),
    )  # fmt: skip
    body = [line for part in sections for line in section(*part)]
    run.publish("Gyro-vertical", [f"{SEEDS}; of the scenarios 1"], body)


if __name__ == "__main__":
    main()

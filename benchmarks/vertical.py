"""The gyro-vertical: predicted against simulated errors, filters in scenarios, coning, speed.

Random numbers have seeds 1, 2, 3 ...
"""

from table import begin, section

import itertools
import math
from timeit import repeat

import numpy as np
from scipy.signal import lfilter

import allanite as al
from allanite.applications.attitude import (
    FILTERS,
    Inertial,
    Loop,
    Setting,
    Trial,
    attitudes,
    compare_filters,
    kalman,
    optimal_time_constant,
    predicted_error,
    rotation_vectors,
)
from allanite.applications.attitude.loop import GRAVITY

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
CONE, CONE_RATE, CONE_SAMPLING = math.radians(1.0), 5.0, 200.0
CONING_FIGURES = {"1 sample": -4.05, "2 samples, without": -16.2, "2 samples": -0.0200}


def errors(models: tuple[str, str], tau: float, n: int, rate: float, rng: np.random.Generator) -> np.ndarray:
    """Errors of one angle in a run, rad, by the recursion of the filter of first order."""
    gyro, tilt = (al.simulate(al.Model(text), n, rate, rng=rng).rate_values for text in models)
    alpha = math.exp(-1 / (rate * tau))
    return lfilter([1.0], [1.0, -alpha], alpha * gyro / rate + (1 - alpha) * tilt / GRAVITY)


def within(error: np.ndarray, rate: float, lowest: float) -> float:
    """Variance of a series above a frequency; the line between its ends is taken off."""
    n = len(error)
    power = np.abs(np.fft.rfft(error - np.linspace(error[0], error[-1], n))) ** 2 * 2 / n**2
    f = np.fft.rfftfreq(n, 1 / rate)
    power[-1] /= 2
    return float(power[f > lowest * 1.0001].sum() + power[np.isclose(f, lowest)].sum() / 2)


def cell(models: tuple[str, str], tau: float, runs: int) -> tuple[float, float]:
    """Predicted and simulated standard deviation over the horizon, arcsec."""
    noise = [al.Model(text) for text in models]
    predicted = predicted_error(*noise, tau, duration=HORIZON, rate=RATE).to("arcsec")
    n = round(LONGER * HORIZON * RATE)
    settle = round(10 * tau * RATE)
    runs_of = (
        errors(models, tau, n + settle, RATE, np.random.default_rng(seed))[settle:] for seed in range(1, runs + 1)
    )
    found = [within(e, RATE, 1 / (2 * HORIZON)) for e in runs_of]
    return predicted, math.sqrt(np.mean(found)) / ARCSEC


def whole(duration: float, runs: int = 30, rate: float = 20.0) -> tuple[float, float, float]:
    """Best time constant, predicted and simulated RMS over whole runs, of flicker and random walk together."""
    found = optimal_time_constant(*map(al.Model, WHOLE), duration=duration)
    tau = found.time_constant
    squares = []
    for seed in range(1, runs + 1):
        e = errors(WHOLE, tau, round(duration * rate), rate, np.random.default_rng(seed))[round(10 * tau * rate) :]
        squares.append(e.var())
    predicted = predicted_error(*map(al.Model, WHOLE), tau, duration=duration, rate=rate).to("arcsec")
    return tau, predicted, math.sqrt(np.mean(squares)) / ARCSEC


def kalman_error(N: float, tilt: float, K: float = 0.0) -> float:
    """Standard deviation of the angle of the steady Kalman filter, rad."""
    return math.sqrt(tilt * math.sqrt(N**2 + 2 * K * tilt))


def coning() -> dict[str, float]:
    """Drift that is left of a coning motion, deg/h, by algorithm."""
    w, dt, n = 2 * math.pi * CONE_RATE, 1 / CONE_SAMPLING, 12_000
    t = np.arange(n + 1) * dt
    # rates of the body whose rotation vector is (0, c cos wt, c sin wt)
    steady = -2 * w * math.sin(CONE / 2) ** 2 * np.diff(t)
    swing = math.sin(CONE)
    increments = np.stack([steady, swing * np.diff(np.cos(w * t)), swing * np.diff(np.sin(w * t))], axis=1)
    start = np.array([math.cos(CONE / 2), 0.0, math.sin(CONE / 2), 0.0])
    vectors = {"1 sample": (1, increments), "2 samples": (2, rotation_vectors(increments)),
               "2 samples, without": (2, increments.reshape(-1, 2, 3).sum(axis=1))}  # fmt: skip
    found = {}
    for name, (k, phi) in vectors.items():
        end = attitudes(phi, start)[-1]
        at = w * t[k * len(phi)]
        true = np.array([math.cos(CONE / 2), 0, math.sin(CONE / 2) * math.cos(at), math.sin(CONE / 2) * math.sin(at)])
        # x part of the quaternion of the error, end times the conjugate of the truth
        x = -end[0] * true[1] + end[1] * true[0] - end[2] * true[3] + end[3] * true[2]
        found[name] = 2 * x / (t[k * len(phi)]) / HOUR
    return found


def speeds(n: int = 1_000_000) -> dict[str, float]:
    """Seconds for so many samples, by filter, after compilation: the shortest of three runs."""
    rng = np.random.default_rng(1)
    data = Inertial(1e-3 * rng.standard_normal((n, 3)), np.array([0, 0, GRAVITY]) + 1e-2 * rng.standard_normal((n, 3)),
                    100.0)  # fmt: skip
    few, found = Inertial(data.gyro[:1000], data.force[:1000], 100.0), {}
    for name, row in FILTERS.items():
        row.run(few, Setting(Loop(1.0, 1e-3)))
        found[name] = min(repeat(lambda row=row: row.run(data, Setting(Loop(1.0, 1e-3))), number=1, repeat=3))
    return found


def closed_forms() -> list[tuple[str, ...]]:
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


def losses() -> list[tuple[str, ...]]:
    rows = []
    for models in MODELS:
        found = optimal_time_constant(*map(al.Model, models), duration=600.0, rate=100.0)
        second = "-" if found.second is None else f"{found.second.to('arcsec'):.2f}"
        rows.append((*models, f"{found.time_constant:.3g}", f"{found.first.to('arcsec'):.2f}", second,
                     f"{found.bound / ARCSEC:.2f}", f"{100 * found.loss:.2f} %"))  # fmt: skip
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


def trial(*, instant: bool) -> Trial:
    """The sensors of the prototype."""
    return Trial(al.Model(GYRO), al.Model(TILT), BIAS, instant=instant)


def scenario_rows() -> list[tuple[str, ...]]:
    both = [compare_filters(trial(instant=how), rng=np.random.default_rng(1)) for how in (False, True)]
    rows = []
    for i, name in enumerate(both[0].filters):
        known, cells = SCENARIO_FIGURES.get(name), []
        for j in range(3):
            cells += [*(f"{math.degrees(s.rms[i, j]):.4f}" for s in both), "-" if known is None else f"{known[j]:.4f}"]
        rows.append((name, *cells))
    return rows


def oscillation_rows() -> list[tuple[str, ...]]:
    """The closed form, with the error at rest added, beside the simulation: mean rates, then instant ones."""
    both = [compare_filters(trial(instant=how), rng=np.random.default_rng(1)) for how in (False, True)]
    rows = []
    for name, tau in FIRST_ORDER.items():
        cells = []
        for how, found in zip((False, True), both, strict=True):
            rest, _, own = np.degrees(found.rms[found.filters.index(name)])
            cells += [f"{math.hypot(rest, math.degrees(swaying(tau, instant=how))):.4f}", f"{own:.4f}"]
        rows.append((name, *cells, f"{SCENARIO_FIGURES[name][2]:.4f}"))
    return rows


def main() -> None:
    run = begin(__doc__, runs=150)
    quoted = {600.0: "0.762 s, 26.3", 3600.0: "0.691 s, 28.3"}
    coloured = [(f"{T:g}", *(f"{v:.4g}" for v in whole(T)), quoted[T]) for T in quoted]
    compared = []
    for models, tau in itertools.product(MODELS, TIMES):
        a, b = cell(models, tau, run.asked.runs)
        compared.append((*models, f"{tau:g}", f"{a:.2f}", f"{b:.2f}", f"{100 * (b / a - 1):+.2f} %"))
    places, ways = ("fixed base", "acceleration", "oscillation"), ("mean", "instant", "expected")
    drifts = coning()
    sections = (
        ("Closed forms", ("what", "here", "expected"), closed_forms()),
        ("Flicker and random walk",
         ("T [s]", "time constant [s]", "predicted [arcsec]", "simulated [arcsec]", "expected"), coloured,
         f"{WHOLE[0]}; {WHOLE[1]}; 30 runs."),
        ("Predicted against simulated",
         ("gyro", "accelerometer", "time constant [s]", "predicted", "simulated", "difference"), compared,
         f"Above 1/(2T), T = {HORIZON:g} s, {RATE:g} Hz, {run.asked.runs} runs of {LONGER} T; arcsec."),
        ("Loss against the optimal causal filter",
         ("gyro", "accelerometer", "time constant [s]", "first order", "second order", "bound", "loss"), losses(),
         "T = 600 s, 100 Hz; arcsec."),
        ("Scenarios", ("filter", *(f"{place} {how}" for place in places for how in ways)), scenario_rows(),
         "RMS of roll and pitch, deg: with mean rates, with rates at the end of each interval, and of an independent "
         "prototype with these."),
        ("Oscillation in closed form",
         ("filter", "mean derived", "mean simulated", "instant derived", "instant simulated", "expected"),
         oscillation_rows(), "RMS of roll and pitch, deg: lever arm and lead of the sampled rates in closed form, with "
         "the error at rest; simulated; and of the prototype."),
        ("Coning", ("algorithm", "here", "expected"),
         [(name, f"{drifts[name]:.4g}", f"{known:.4g}") for name, known in CONING_FIGURES.items()],
         "Drift left of 987 deg/h, deg/h: cone of 1 deg at 5 Hz, sampled at 200 Hz."),
        ("Speed", ("filter", "s for 1e6 samples"), [(k, f"{v:.2f}") for k, v in speeds().items()],
         "The shortest of three runs."),
    )  # fmt: skip
    body = [line for part in sections for line in section(*part)]
    run.publish("Gyro-vertical", ["random numbers with seeds 1, 2, 3 ..."], body)


if __name__ == "__main__":
    main()

"""A constant rate in two minutes: the paper's experiment on the simulated GL-1, predictions, the search of a staircase.

With --write, the errors of the first run are drawn as figure 10 of the paper, for the page about it.
"""

from table import ROOT, SEEDS, Row, begin, section, seeded, shared, spread

import math
import time
from functools import cache

import numpy as np
from scipy.linalg import matmul_toeplitz, solve_toeplitz

import allanite as al
from allanite.applications.constant_rate import RATE_ESTIMATORS, EstimatorSettings, Experiment, ExperimentSettings
from allanite.applications.constant_rate.run import task_of
from allanite.simulation.record import GL1

ARCSEC = math.pi / 180 / 3600
N, RATE, T = 48_000, 400.0, 120.0
TRUE = 12.4392
PULSE = GL1.pulse
OPTIONS = EstimatorSettings(quantum=PULSE * ARCSEC)
PAPER = {"mean": "0.0034", "hamming": "0.0022", "conditional": "0.0018", "staircase": "0.0013"}
LINEAR = {"mean": "mean", "hamming": "hamming", "regression": "regression", "bound": "optimal"}
SWINGS = ((0.52, 30), (0.14, 46), (0.25, 84))  # arcsec, s
RHO = (0, 0.03, 0.1, 0.3, 1, 3, 10, 100)
NOISES = (0.0, 0.05, 0.5, 1.0, 2.0, 5.0)  # white noise of the angle, pulses
SEARCHES = {"default": {}, "certified": {"certified": True}, "descent": {"descent": 100}}
STEPS = (0, 1, 2, 3, 5, 10, 20, 100)
FIGURE = ROOT / "docs" / "figures" / "rate_paper.svg"

Table = tuple[Row, list[Row]]


@cache
def laser(seed: int) -> al.Record:
    """94 intervals of two minutes."""
    rng = np.random.default_rng(seed)
    return al.simulation.simulate_ring_laser(GL1, TRUE, 94 * N, RATE, rng=rng, name="GL-1, simulated")


def made(seed: int, **more: object) -> Experiment:
    """The paper's experiment."""
    settings = ExperimentSettings(**more) if more else ExperimentSettings(reference=(TRUE + GL1.bias) * ARCSEC)
    return al.constant_rate.experiment(laser(seed), GL1.model, settings)


def deviations(job: tuple[int]) -> list[float]:
    """Scatter of each method in a run, deg/h."""
    run = made(*job)
    return [run.scatter(method).deviation / ARCSEC for method in RATE_ESTIMATORS]


def exact(method: str, model: al.Model = GL1.model, options: EstimatorSettings | None = OPTIONS) -> float:
    """Standard deviation from the covariance alone, deg/h."""
    return al.constant_rate.predicted_standard_error(method, model, size=N, rate=RATE, options=options) / ARCSEC


def acceptance(runs: int) -> Table:
    """The paper's experiment."""
    ((_, found),) = spread(deviations, [()], runs, first=1)
    rows = []
    for method, column in zip(RATE_ESTIMATORS, np.transpose(found), strict=True):
        rms = math.sqrt(np.square(column).mean())
        cell = f"{rms:.5f} ({column.min():.5f} .. {column.max():.5f})"
        rows.append((method, PAPER.get(method, "-"), f"{exact(method):.5f}", cell))
    return ("method", "paper", "exact covariance", f"{runs} runs"), rows


def correlated_angle(sigma: float, seconds: float) -> list[float]:
    """Standard errors under angle noise that is exponentially correlated and nothing else, deg/h."""
    c = sigma**2 * np.exp(-np.arange(N + 1) / RATE / seconds)
    rates = RATE**2 * np.r_[2 * (c[0] - c[1]), 2 * c[1:-1] - c[:-2] - c[2:]]
    setting = task_of(al.Record(np.zeros(N), rate=RATE, unit="deg/h"), None, "mean")
    weights = [RATE_ESTIMATORS[method].weights(setting) for method in LINEAR if method in RATE_ESTIMATORS]
    errors = [math.sqrt(w @ matmul_toeplitz(rates, w)) for w in weights]
    return [*errors, 1 / math.sqrt(solve_toeplitz(rates, np.ones(N)).sum())]


def fitting() -> Table:
    """Stationary noise that fits rows of the paper's table 3."""
    rates = (f", GM2 {a * math.pi * 2**0.5 / period} deg/h {1 / period} Hz 1e-6" for a, period in SWINGS)
    swinging = al.Model("N 1.67e-4 deg/sqrt(h)" + "".join(rates))
    models = {
        "random walk and white angle noise (GL1.model)": [exact(method) for method in LINEAR.values()],
        "angle noise of 0.286 arcsec, correlated over 3.3 s": correlated_angle(0.286, 3.3),
        "angle noise of 0.30 arcsec, correlated over 15 s": correlated_angle(0.30, 15.0),
        "random walk of 1.67e-4 deg/sqrt(h), swings of 0.52, 0.14, 0.25 arcsec in 30, 46, 84 s": [
            exact(method, swinging, None) for method in LINEAR.values()
        ],
    }
    rows = [("the paper", "0.0034", "0.0022", "0.0018", "(staircase 0.0013)")]
    rows += [(name, *(f"{error:.5f}" for error in errors)) for name, errors in models.items()]
    return ("noise", "mean", "hamming", "regression", "Cramer-Rao bound"), rows


def efficiency() -> Table:
    """What averaging and regression lose, as angle noise grows beside the random walk."""
    white, rows = al.N(3e-3, "deg/sqrt(h)"), []
    for rho in RHO:
        model = white + al.Q(rho * white.value * math.sqrt(T), "rad")
        *errors, best = (exact(method, model, None) for method in LINEAR.values())
        rows.append((f"{rho:g}", *(f"{error / best:.4g}" for error in errors)))
    return ("sigma / (N sqrt T)", "mean", "hamming", "regression"), rows


def noisy(sigma: float, truth: float, rng: np.random.Generator) -> al.Record:
    """Counts of a gyro that turns by `truth` pulses a sample, with white noise of the angle, in pulses."""
    y = np.floor(truth * np.arange(N + 1) + rng.random() + sigma * rng.standard_normal(N + 1))
    return al.Record(np.diff(y).astype(int), rate=RATE, unit="arcsec", kind="count", scale=PULSE)


def searched(job: tuple[float, int]) -> list[float]:
    """Of a record: the least misfit, misfits above it, times in ms, and errors in deg/h."""
    sigma, number = job
    rng = seeded(number, "search", sigma)
    truth = rng.uniform(0.09, 0.1)
    record, found, times = noisy(sigma, truth, rng), {}, []
    for name, options in SEARCHES.items():
        start = time.process_time()
        found[name] = al.constant_rate.estimate(record, "staircase", options=EstimatorSettings(**options))
        times.append(1e3 * (time.process_time() - start))
    least = found["certified"].details["misfit"]
    if found["certified"].details["least possible misfit"] != least:
        raise RuntimeError(f"not certified: noise {sigma}, record {number}")
    above = [found[name].details["misfit"] - least for name in ("default", "descent")]
    ends = found["certified"], al.constant_rate.estimate(record, "regression")
    return [least, *above, *times, *(e.to("deg/h") - truth * RATE * PULSE for e in ends)]


def search(records: int) -> Table:
    """Noise of the angle, and what each search makes of it."""
    rows = []
    for (sigma,), results in spread(searched, [(sigma,) for sigma in NOISES], records):
        least, default, descent, *others = np.transpose(results)
        cells = [least[-1], default.max(), descent.mean(), *map(np.median, others[:-2])]
        rms = (f"{math.sqrt(np.mean(each**2)):.1e}" for each in others[-2:])
        rows.append((f"{sigma:g}", *(f"{cell:.0f}" for cell in cells), *rms))
    heads = ("noise, pulses", "least misfit", "default above, most", "descent above, mean")
    return (*heads, *(f"{name}, ms" for name in SEARCHES), "staircase rms, deg/h", "regression rms, deg/h"), rows


def descents() -> Table:
    """Scatter after so many steps of the paper's descent, and of methods without it, in the run of seed 1."""

    def deviation(method: str, steps: int | None = None) -> str:
        run = made(1, methods=(method,), options=EstimatorSettings(descent=steps))
        return f"{run.scatter(method).deviation / ARCSEC:.5f}"

    rows = [(f"{steps} steps", deviation("staircase", steps)) for steps in STEPS]
    others = ("mean", "regression", "staircase", "optimal")
    return ("method", "std, deg/h"), [*rows, *((method, deviation(method)) for method in others)]


def counted(rng: np.random.Generator) -> al.Record:
    """An interval of the GL-1 by the formulas of the paper: random walk, residual of the dither, whole pulses."""
    t = np.arange(N + 1) / RATE
    steps = GL1.random_walk * 60 / math.sqrt(RATE) * rng.standard_normal(N)  # deg/sqrt(h) is 60 arcsec/sqrt(s)
    angle = (TRUE + GL1.bias) * t + np.append(0.0, np.cumsum(steps))  # deg/h is arcsec/s
    wander = np.cumsum(rng.standard_normal(N + 1)) * math.sqrt(2 / (GL1.coherence * RATE))
    dither = 2 * math.pi * (rng.uniform(*GL1.residual_band) * t + rng.random()) + wander
    pulses = np.floor((angle + GL1.residual * np.sin(dither)) / PULSE + rng.random())
    return al.Record(np.diff(pulses).astype(int), rate=RATE, unit="arcsec", kind="count", scale=PULSE)


def errors(job: tuple[int]) -> list[tuple[float, float]]:
    """Error and predicted standard deviation of each method in an interval, deg/h."""
    record = counted(seeded(job[0], "prediction"))
    found = (al.constant_rate.estimate(record, method, model=GL1.model) for method in RATE_ESTIMATORS)
    return [(e.to("deg/h") - TRUE - GL1.bias, e.standard_error / ARCSEC) for e in found]


def predictions(records: int) -> Table:
    """Standard deviation over that predicted, and coverage of the 95 % interval."""
    ((_, results),) = spread(errors, [()], records)
    rows = []
    for method, (off, sigma) in zip(RATE_ESTIMATORS, np.array(results).transpose(1, 2, 0), strict=True):
        ratio = math.sqrt(float(np.square(off / sigma).mean()))
        rows.append((method, f"{sigma[0]:.5f}", f"{ratio:.3f}", shared(np.abs(off) < 1.959964 * sigma)))
    return ("method", "predicted, deg/h", "rms error over it", "cover of 95 %"), rows


def main() -> None:
    run = begin(__doc__, runs=6, records=1000, searches=20)
    records, searches = run.asked.records, run.asked.searches
    parts = (
        ("The paper's experiment", acceptance(run.asked.runs),
         "Standard deviations of 94 two-minute errors of the simulated GL-1, deg/h (numerically '/min). Runs: the root "
         "mean square of their deviations, least and largest."),
        ("Noise that fits the paper", fitting(), "Exact standard deviations of two-minute errors, deg/h."),
        ("The paper's descent", descents(),
         "Standard deviation of 94 two-minute errors, seed 1, after at most so many steps from the interval's own "
         "count, and that of the methods without it."),
        ("Predictions", predictions(records),
         f"{records} intervals of a gyro as the GL-1, simulated by the script itself; a ratio is known to "
         f"{70.7 / records**0.5:.1f} %."),
        ("When to average", efficiency(),
         "Standard error over the bound, by angle noise over random walk in the measuring time; 48 000 samples."),
        ("The search for the staircase", search(searches),
         f"{searches} records of 48 000 counts with white angle noise, for each noise; misfit above the least there "
         "is, which the certified search proves and which is printed of the last record."),
    )  # fmt: skip
    body = [line for title, table, about in parts for line in section(title, *table, about)]
    run.publish("A constant rate in two minutes", [f"{SEEDS}; of runs their numbers from 1 on"], body)
    if run.asked.write:
        al.plot(made(1), path=FIGURE, force=True)


if __name__ == "__main__":
    main()

"""A constant rate in two minutes: the paper's experiment on the simulated GL-1, bounds, the search, speed.

The figure of the run with seed 1, rate.svg, is put beside the table.

Random numbers have seeds 1, 2, 3 ...
"""

from table import begin, section

import itertools
import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.linalg import solve_toeplitz

import allanite as al
from allanite.applications.constant_rate import (
    RATE_ESTIMATORS,
    EstimatorSettings,
    Experiment,
    ExperimentSettings,
    experiment,
    predicted_standard_error,
)
from allanite.applications.constant_rate.row import TARGETS
from allanite.applications.constant_rate.run import task_of
from allanite.simulation.record import GL1
from allanite.statistics.moments.gls import autocovariance

ARCSEC = math.pi / 180 / 3600
N, RATE, T = 48_000, 400.0, 120.0
TRUE = 12.4392
PULSE = GL1.pulse
OPTIONS = EstimatorSettings(quantum=PULSE * ARCSEC)
PAPER = {"mean": "0.0034", "hamming": "0.0022", "conditional": "0.0018", "staircase": "0.0013"}
SWINGS = ((0.52, 30), (0.14, 46), (0.25, 84))  # arcsec, s
RHO = (0, 0.03, 0.1, 0.3, 1, 3, 10, 100)

Table = tuple[tuple[str, ...], list[tuple[str, ...]]]


def gl1_run(seed: int, warm_up: float = 0.0) -> Experiment:
    """94 intervals of two minutes."""
    gyro = replace(GL1, warm_up=warm_up)
    record = al.simulation.simulate_ring_laser(
        gyro, TRUE, 94 * N, RATE, rng=np.random.default_rng(seed), name="GL-1, simulated"
    )
    return experiment(record, GL1.model, ExperimentSettings(reference=(TRUE + GL1.bias) * ARCSEC))


def exact(method: str) -> float:
    """Standard deviation on the GL-1, from the covariance alone, deg/h."""
    return predicted_standard_error(method, GL1.model, size=N, rate=RATE, options=OPTIONS) / ARCSEC


def deviations(found: Experiment) -> list[float]:
    return [found.scatter(method).deviation / ARCSEC for method in RATE_ESTIMATORS]


def acceptance(runs: int) -> Table:
    plain, warm = (np.array([deviations(gl1_run(seed, w)) for seed in range(1, runs + 1)]) for w in (0.0, -0.01))
    rows = []
    for i, method in enumerate(RATE_ESTIMATORS):
        cells = [method, PAPER.get(method, "-"), f"{exact(method):.5f}", f"{plain[0, i]:.5f}"]
        for table in (plain, warm):
            mean = math.sqrt(float(np.square(table[:, i]).mean()))
            cells.append(f"{mean:.5f} ({table[:, i].min():.5f} .. {table[:, i].max():.5f})")
        rows.append(tuple(cells))
    return ("method", "paper", "exact covariance", "seed 1", f"{runs} runs", "with warm-up"), rows


def correlated_angle(sigma: float, seconds: float) -> dict[str, float]:
    """Standard errors under angle noise that is exponentially correlated and nothing else, deg/h."""
    c = sigma**2 * np.exp(-np.arange(N + 1) / RATE / seconds)
    rates = RATE**2 * np.r_[2 * (c[0] - c[1]), 2 * c[1:-1] - c[:-2] - c[2:]]
    setting = task_of(al.Record(np.zeros(N), rate=RATE, unit="deg/h"), None, "mean")
    weights = {m: RATE_ESTIMATORS[m].weights(setting) for m in ("mean", "hamming", "regression")}
    found = {m: math.sqrt(w @ product(rates, w)) for m, w in weights.items()}
    return found | {"bound": 1 / math.sqrt(solve_toeplitz(rates, np.ones(N)).sum())}


def fitting() -> Table:
    """Stationary noise that fits rows of the paper's table 3."""
    white = {m: exact("optimal" if m == "bound" else m) for m in ("mean", "hamming", "regression", "bound")}
    models = {"random walk and white angle noise (GL1.model)": white}
    models["angle noise of 0.286 arcsec, correlated over 3.3 s"] = correlated_angle(0.286, 3.3)
    models["angle noise of 0.30 arcsec, correlated over 15 s"] = correlated_angle(0.30, 15.0)
    rates = [f"GM2 {a * math.pi * 2**0.5 / period} deg/h {1 / period} Hz 1e-6" for a, period in SWINGS]
    swinging = al.Model(f"N 1.67e-4 deg/sqrt(h), {', '.join(rates)}")
    models["random walk of 1.67e-4 deg/sqrt(h), swings of 0.52, 0.14, 0.25 arcsec in 30, 46, 84 s"] = {
        m: predicted_standard_error(method, swinging, size=N, rate=RATE) / ARCSEC
        for m, method in zip(white, ("mean", "hamming", "regression", "optimal"), strict=True)
    }
    rows = [("the paper", "0.0034", "0.0022", "0.0018", "(staircase 0.0013)")]
    rows += [(name, *(f"{found[m]:.5f}" for m in white)) for name, found in models.items()]
    return ("noise", "mean", "hamming", "regression", "Cramer-Rao bound"), rows


def efficiency() -> Table:
    white = al.N(3e-3, "deg/sqrt(h)")
    rows = []
    for rho in RHO:
        model = white + al.Q(rho * white.value * math.sqrt(T), "rad")
        errors = [
            predicted_standard_error(m, model, size=N, rate=RATE) for m in ("mean", "hamming", "regression", "optimal")
        ]
        rows.append((f"{rho:g}", *(f"{error / errors[-1]:.4g}" for error in errors[:-1])))
    return ("sigma / (N sqrt T)", "mean", "hamming", "regression"), rows


MIXTURES = {
    "white": "N", "quantization": "Q", "white, quantization": "QN", "white, flicker": "NB", "white, random walk": "NK",
    "quantization, flicker": "QB", "all": "QNBK",
}  # fmt: skip
SIZES = {"Q": al.Q(0.25, "arcsec"), "N": al.N(1e-3, "deg/sqrt(h)"), "B": al.B(0.01, "deg/h")}
SIZES["K"] = al.K(0.1, "deg/h/sqrt(h)")


def levinson_bound(model: al.Model, target: str) -> float:
    """Least standard error at 48 000 samples by Levinson's recursion."""
    c = autocovariance(model, N, RATE)
    c = c + 10 * np.abs(c).max()  # a constant covariance makes the generalised one positive, and changes no contrast
    settled = autocovariance([t for t in model if t.symbol in "QN"], N, RATE)
    aim = TARGETS[target](N)
    slow = product(c - settled, aim)
    u, v = solve_toeplitz(c, np.column_stack([slow, np.ones(N)])).T
    w = u + v * (1 - u.sum()) / v.sum()
    error = w @ product(settled, w) + (w - aim) @ product(c - settled, w - aim)
    return math.sqrt(error)


def product(row: np.ndarray, v: np.ndarray) -> np.ndarray:
    from scipy.linalg import matmul_toeplitz

    return matmul_toeplitz(row, v)


def bounds() -> Table:
    rows = []
    for (name, symbols), target in itertools.product(MIXTURES.items(), ("mean", "start")):
        if target == "start" and not set(symbols) & set("BK"):
            continue
        model = al.Model(tuple(SIZES[s] for s in symbols))
        seconds, found = timed(partial(predicted_standard_error, "optimal", model, size=N, rate=RATE, target=target))
        start = time.perf_counter()
        bound = levinson_bound(model, target)
        slow = time.perf_counter() - start
        over = f"{100 * (found / bound - 1):+.4f}"
        rows.append((name, target, f"{found / ARCSEC:.6f}", over, f"{1e3 * seconds:.0f}", f"{slow:.0f}"))
    return ("noise", "target", "standard error, deg/h", "over the bound, %", "ms", "Levinson, s"), rows


def noisy(sigma: float, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    y = np.floor((0.094 + 1e-4 * seed) * np.arange(N + 1) + rng.random() + sigma * rng.standard_normal(N + 1))
    return y - y[0]


def search(records: int) -> Table:
    """Noise of the angle, and what each search makes of it."""
    rows = []
    for sigma in (0.0, 0.05, 0.5, 1.0, 2.0, 5.0):
        options = {"default": EstimatorSettings(), "certified": EstimatorSettings(certified=True)}
        options["descent"] = EstimatorSettings(descent=100)
        excess, times, errors = {"default": [], "descent": []}, {name: [] for name in options}, []
        for seed in range(1, records + 1):
            y = noisy(sigma, seed)
            record = al.Record(np.diff(y).astype(int), rate=RATE, unit="arcsec", kind="count", scale=PULSE)
            found = {}
            for name, chosen in options.items():
                seconds, found[name] = timed(
                    lambda o=chosen, r=record: al.constant_rate.estimate(r, "staircase", options=o), 1
                )
                times[name].append(seconds)
            least = found["certified"].details["misfit"]
            if found["certified"].details["least possible misfit"] != least:
                raise RuntimeError(f"not certified: noise {sigma}, seed {seed}")
            for name, above in excess.items():
                above.append(found[name].details["misfit"] - least)
            truth = (0.094 + 1e-4 * seed) * RATE * PULSE
            regression = al.constant_rate.estimate(record, "regression").to("deg/h")
            errors.append((found["certified"].to("deg/h") - truth, regression - truth))
        rms = np.sqrt(np.square(errors).mean(axis=0))
        cells = [f"{sigma:g}", f"{least:.0f}", f"{max(excess['default']):.0f}", f"{np.mean(excess['descent']):.0f}"]
        cells += [f"{1e3 * float(np.median(times[k])):.0f}" for k in ("default", "certified", "descent")]
        rows.append((*cells, f"{rms[0]:.1e}", f"{rms[1]:.1e}"))
    headings = ("noise, pulses", "least misfit", "default above, most", "descent above, mean", "default, ms")
    return (*headings, "certified, ms", "descent, ms", "staircase rms, deg/h", "regression rms, deg/h"), rows


def descents() -> Table:
    """Scatter after so many steps of the paper's descent, and of methods without it, in the run of seed 1."""
    record = al.simulation.simulate_ring_laser(GL1, TRUE, 94 * N, RATE, rng=np.random.default_rng(1))

    def deviation(method: str, steps: int | None = None) -> str:
        settings = ExperimentSettings(methods=(method,), options=EstimatorSettings(descent=steps))
        return f"{experiment(record, GL1.model, settings).scatter(method).deviation / ARCSEC:.5f}"

    rows = [(f"{steps} steps", deviation("staircase", steps)) for steps in (0, 1, 2, 3, 5, 10, 20, 100)]
    others = ("mean", "regression", "staircase", "optimal")
    return ("method", "std, deg/h"), [*rows, *((method, deviation(method)) for method in others)]


def predictions(records: int) -> Table:
    """Standard deviation over that predicted, and coverage of the 95 % interval."""
    found = {method: [] for method in RATE_ESTIMATORS}
    for seed in range(1, records + 1):
        record = al.simulation.simulate_ring_laser(GL1, TRUE, N, RATE, rng=np.random.default_rng(seed))
        for method, errors in found.items():
            estimate = al.constant_rate.estimate(record, method, model=GL1.model)
            errors.append(((estimate.to("deg/h") - TRUE - GL1.bias), estimate.standard_error / ARCSEC))
    rows = []
    for method, pairs in found.items():
        error, predicted = np.array(pairs).T
        ratio = math.sqrt(float(np.square(error).mean())) / predicted[0]
        covered = 100 * float((np.abs(error) < 1.959964 * predicted).mean())
        rows.append((method, f"{predicted[0]:.5f}", f"{ratio:.3f}", f"{covered:.1f}"))
    return ("method", "predicted, deg/h", "rms error over it", "cover of 95 %"), rows


def speed() -> Table:
    full = al.Model(tuple(SIZES.values()))
    seconds, _ = timed(lambda: predicted_standard_error("optimal", full, size=N, rate=RATE))
    million, _ = timed(lambda: predicted_standard_error("optimal", full, size=10**6, rate=RATE), times=1)
    record = al.simulation.simulate_ring_laser(GL1, TRUE, 94 * N, RATE, rng=np.random.default_rng(1))
    whole, _ = timed(lambda: experiment(record, GL1.model), times=1)
    single = al.Record(record.values[:N], rate=RATE, unit="arcsec", kind="count", scale=PULSE)
    stairs, _ = timed(lambda: al.constant_rate.estimate(single, "staircase"), times=9)
    rows = [
        ("optimal weights of Q, N, B, K, 48 000 samples", f"{seconds:.3f} s", "0.3 s", met(seconds < 0.3)),
        ("the same, 1 000 000 samples", f"{million:.1f} s", "-", "-"),
        ("staircase, default search, a GL-1 interval", f"{1e3 * stairs:.0f} ms", "50 ms", met(stairs < 0.05)),
        ("94 intervals of 48 000 samples, all methods", f"{whole:.1f} s", "10 s", met(whole < 10)),
    ]
    return ("job", "time", "demanded", ""), rows


def met(good: bool) -> str:
    return "met" if good else "missed"


def timed(job: Callable, times: int = 3) -> tuple[float, object]:
    """Least processor time of some runs, after one that compiles."""
    result, taken = job(), []
    for _ in range(times):
        start = time.process_time()
        result = job()
        taken.append(time.process_time() - start)
    return min(taken), result


def draw(path: Path) -> None:
    """The errors of the run with seed 1, as figure 10 of the paper."""
    path.parent.mkdir(parents=True, exist_ok=True)
    al.plot(gl1_run(1), path=path, force=True)


def main() -> None:
    run = begin(__doc__, runs=6, records=400, searches=20)
    options = run.asked
    parts = (
        ("Speed", "Processor time on one core.", speed()),
        (
            "The paper's experiment",
            "Standard deviations of 94 two-minute errors of the simulated GL-1, deg/h (numerically '/min). Runs: the "
            "root mean square of their deviations, least and largest. Warm-up: -0.01 deg/h at the start, 10 min.",
            acceptance(options.runs),
        ),
        ("Noise that fits the paper", "Exact standard deviations of two-minute errors, deg/h.", fitting()),
        (
            "The paper's descent",
            "Standard deviation of 94 two-minute errors, seed 1, after at most so many steps from the interval's own "
            "count, and that of the methods without it.",
            descents(),
        ),
        (
            "Predictions",
            f"{options.records} intervals of the simulated GL-1; a ratio is known to "
            f"{70.7 / options.records**0.5:.1f} %.",
            predictions(options.records),
        ),
        (
            "When to average",
            "Standard error over the bound, by angle noise over random walk in the measuring time; 48 000 samples.",
            efficiency(),
        ),
        ("The bound", "The optimal weights at 48 000 samples against Levinson's recursion.", bounds()),
        (
            "The search for the staircase",
            f"{options.searches} records of 48 000 counts with white angle noise, for each noise; misfit above the "
            "least there is, which the certified search proves and which is printed of the last record.",
            search(options.searches),
        ),
    )
    notes = [
        f"seeds 1..{options.runs} for runs, 1..{options.records} for predictions, 1..{options.searches} for searches"
    ]
    run.publish(
        "A constant rate in two minutes",
        notes,
        [line for title, about, made in parts for line in section(title, *made, about)],
    )
    if options.write:
        draw(options.write.with_suffix(".svg"))


if __name__ == "__main__":
    main()

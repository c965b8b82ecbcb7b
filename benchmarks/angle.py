"""Angle sensors of a gimbal: is the planned accuracy that of simulated experiments, and which range of h is best.

The experiment is that of docs/angle_paper.md: latitude 60 deg, one hour from every full hour after h = 0, a reading
every 10 s, noise 1, harmonics 128 and 256 of h and q, prior standard deviations 3 (amplitudes)
and 10 (rest). In a run the true constants are drawn from that prior, the errors are added to the angles, and the
cosine is computed without linearising.
"""

from table import SEEDS, begin, least, markdown, seeded, spread

import itertools
import math
from collections.abc import Sequence

import numpy as np

import allanite as al

UNIT = 1e-7  # rad; small, so that the linear model holds
PRIOR = (3.0, 10.0)
LATITUDE = math.radians(60)
NUISANCE = ("ax", "az", "A1", "A2", "A3")
HEADINGS = (
    "base", "law of q", "h, deg", "planned", "over best", "reference", "simulated", "over best ", "reference ",
    "worst ratio", "within 3 sigma %", "95 % cover",
)  # fmt: skip


EXPERIMENTS = {
    ("still", "linear", 0.0): ((4.62, 1.25, 1, 1.24, 1.83, 7.69), (4.32, 1.23, 1, 1.23, 1.73, 7.0)),
    ("still", "exact", 0.0): ((1, 1.72, 1.15, 1.30, 2.81, 9.09), ()),
    ("still, random walk", "linear", 0.1): ((), (5.73, 1.35, 1, 1.26, 1.95, 10.9)),
}
"""Base, law of q, and random walk; what an independent prototype plans and simulates, over the best range."""
HOUR, STEP = 3600.0, 10.0  # s


def plan(law: str, hour: int) -> al.angle.AnglePlan:
    """What is expected of the readings of an hour."""
    settings = al.angle.AngleSettings(LATITUDE, HOUR, interval=STEP, prior=PRIOR, q_law=law)
    return al.angle.plan(settings, HOUR * hour)


def run(job: tuple[str, str, float, int, int]) -> np.ndarray:
    """Errors of the eight amplitudes over UNIT, and over their standard errors, shape (2, 8)."""
    base, law, walk, hour, number = job
    rng = seeded(number, base, law, hour)
    true, rest = (sd * UNIT * rng.standard_normal(n) for sd, n in zip(PRIOR, (8, 5), strict=True))
    sensors = {
        name: al.angle.Harmonics.of({128: tuple(part[:2]), 256: tuple(part[2:])})
        for name, part in (("h", true[:4]), ("q", true[4:]))
    }
    gimbals = al.angle.gimbals(HOUR * hour + np.arange(0.0, HOUR, STEP), latitude=LATITUDE, q_law=law)
    z = al.angle.simulate(
        gimbals, sensors, nuisance=dict(zip(NUISANCE, rest, strict=True)),
        sigma=UNIT, walk=walk * UNIT, rng=rng,
    )  # fmt: skip
    found = al.angle.estimate(z, gimbals, sigma=UNIT, prior=(PRIOR[0] * UNIT, PRIOR[1] * UNIT)).solution
    error = found.values[:8] - true
    return np.array([error / UNIT, error / found.errors[:8]])


def rms(errors: np.ndarray) -> np.ndarray:
    """Root mean square about the truth of each amplitude; errors of shape (runs, 8)."""
    return np.sqrt((errors**2).mean(axis=0))


def rows(experiment: tuple[str, str, float], runs: int) -> list[tuple[str, ...]]:
    """A line for each full hour."""
    base, law, _ = experiment
    plans = [plan(law, hour) for hour in range(6)]
    made = [np.array(each) for _, each in spread(run, [(*experiment, hour) for hour in range(6)], runs)]
    totals = [p.total for p in plans], [rms(errors[:, 0]).sum() for errors in made]
    lines = []
    for each, errors, *beside in zip(plans, made, *map(compared, totals, EXPERIMENTS[experiment]), strict=True):
        low, high = np.degrees(each.h)
        ratio, size = rms(errors[:, 0]) / each.errors[:8], np.abs(errors[:, 1])
        shares = f"{100 * (size < 3).mean():.2f}", f"{100 * (size < 1.96).mean():.1f}"
        worst = f"{ratio[np.abs(ratio - 1).argmax()]:.2f}"
        lines.append((base, law, f"{low:.1f} to {high:.1f}", *beside[0], *beside[1], worst, *shares))
    return lines


def compared(totals: Sequence[float], wanted: Sequence[float]) -> list[tuple[str, str, str]]:
    """Of each hour: a sum, the sum over the least of all hours, and that of an independent prototype, if it has it."""
    ratios = [f"{each:.2f}" for each in wanted] or ["-"] * len(totals)
    return [(f"{each:.3f}", f"{each / min(totals):.2f}", ratio) for each, ratio in zip(totals, ratios, strict=True)]


def windows() -> list[str]:
    """The best windows, as lines."""
    lines = []
    for law, minutes in itertools.product(("linear", "exact"), (60, 30)):
        best = al.angle.scan(al.angle.AngleSettings(LATITUDE, 60.0 * minutes, 10.0, q_law=law)).best
        window = "h {:.1f} to {:.1f} deg, sum of deviations".format(*np.degrees(best.h))
        lines.append(f"best {minutes} min, {law} law: {window} {best.total:.2f}")
    return lines


def speed(n: int = 1_000_000) -> tuple[float, float]:
    """Processor time of the estimate from n readings, s; largest relative difference of recursive and batch."""

    def simulated(size: int) -> tuple[np.ndarray, al.angle.Gimbals]:
        gimbals = al.angle.gimbals(7200 + 3600 / size * np.arange(size), latitude=LATITUDE)
        return al.angle.simulate(gimbals, sensors, sigma=UNIT, rng=np.random.default_rng(1)), gimbals

    sensors = {"h": al.angle.Harmonics.of({128: (3 * UNIT, UNIT)}), "q": al.angle.Harmonics.of({256: (UNIT, -UNIT)})}
    al.angle.estimate(*simulated(1000))  # compiled, or loaded, before the clock runs
    made = simulated(n)
    seconds = least(lambda: al.angle.estimate(*made), 1)
    found, twin = (al.angle.estimate(*made, **how).solution.values for how in ({}, {"method": "batch"}))
    return seconds, float(np.max(np.abs(found - twin) / np.abs(twin)))


def main() -> None:
    asked = begin(__doc__, runs=3000)
    runs = asked.asked.runs
    seconds, difference = speed()
    lines = [line for experiment in EXPERIMENTS for line in rows(experiment, runs)]
    notes = [
        f"{SEEDS}; {runs} runs a row; latitude 60 deg, a reading every 10 s, noise 1, prior 3 and 10, turn 300 s",
        "planned, simulated: sum over the eight amplitudes of the expected deviation, and of the root mean square "
        "error; over best: over the least of the six ranges; reference: that ratio as an independent prototype gave "
        "it; worst ratio: simulated over planned of the amplitude where it departs most; within 3 sigma, cover: of all "
        "estimates",
        f"1000000 readings, 13 constants: {seconds:.2f} s; recursive from batch by at most {difference:.1e} relative",
        *windows(),
    ]
    asked.publish("Angle sensors: planned against simulated accuracy", notes, markdown(HEADINGS, lines))


if __name__ == "__main__":
    main()

"""Is a simulated record what it is said to be: expected over simulated Allan variance and spectrum, every octave.

Records of 4096 readings of every term and of mixtures; sinusoids with a random phase. Each cell is the mean over the
records less the exact expectation, in standard errors of that mean (from the scatter of the records).
"""

from table import SEEDS, begin, markdown, seeded, spread

import math

import numpy as np
from scipy.fft import dct

import allanite as al

SIZE, RATE = 4096, 100.0
OCTAVES = [2**i for i in range(12)]
MODELS = {
    "Q": "Q 0.4 arcsec",
    "N": "N 0.05 deg/sqrt(h)",
    "B": "B 1 deg/h",
    "K": "K 5 deg/h/sqrt(h)",
    "GM, T = 0.3 samples": "GM 1 deg/h 0.003 s",
    "GM, T = 20 samples": "GM 1 deg/h 0.2 s",
    "GM, T = 1000 samples": "GM 1 deg/h 10 s",
    "F": "F 0.4 arcsec",
    "GMA, T = 0.3 samples": "GMA 0.4 arcsec 0.003 s",
    "GMA, T = 20 samples": "GMA 0.4 arcsec 0.2 s",
    "GM2": "GM2 1 deg/h 3 Hz 0.15",
    "N, GM and GML": "N 0.003 deg/sqrt(h), GM 1 deg/h 0.2 s, GML 1 deg/h 5 s",
    "N and W": "N 0.003 deg/sqrt(h), W 5 deg/h 10 s",
    "N and R": "N 0.003 deg/sqrt(h), R 900 deg/h^2",
    "N and Sine": "N 0.003 deg/sqrt(h), Sine 1 deg/h 3.1 Hz",
    "MEMS": al.planning.SENSORS["mems"],
    "FOG": al.planning.SENSORS["fog"],
    "RLG": al.planning.SENSORS["rlg"],
    "all": "Q 0.01 arcsec, N 0.003 deg/sqrt(h), B 1 deg/h, K 50 deg/h/sqrt(h), GM 2 deg/h 0.5 s, R 900 deg/h^2, "
    "Sine 1 deg/h 3.1 Hz",
}
HEADINGS = ("noise", "of", *map(str, OCTAVES), "largest")


def with_phase(model: al.Model, phase: float) -> al.Model:
    """The model, its sinusoids at a phase."""
    return al.Model(
        tuple(al.Term(t.symbol, t.value, t.signal, (t.shape[0], phase)) if t.row.periodic else t for t in model)
    )


def simulated(job: tuple[str, int]) -> tuple[np.ndarray, np.ndarray]:
    """Allan variances and mean powers of octaves of the cosine transform of a record."""
    model, rng = al.Model(MODELS[job[0]]), seeded(job[1], "simulation", job[0])
    noise = al.Model(tuple(t for t in model if t.row.waveform is None))
    record = al.simulate(with_phase(model, rng.uniform(0, 2 * math.pi)), SIZE, RATE, rng=rng)
    values = al.simulate(noise, SIZE, RATE, rng=rng).values
    return al.deviation(record, "oadev", m=OCTAVES).variance, bands(dct(values, norm="ortho")[1:] ** 2)


def bands(power: np.ndarray) -> np.ndarray:
    """Means over k = 1, 2-3, 4-7, ..."""
    return np.array([power[m - 1 : 2 * m - 1].mean() for m in OCTAVES])


def expected(name: str) -> tuple[np.ndarray, np.ndarray]:
    """What `simulated` should be on average."""
    model, k = al.Model(MODELS[name]), np.arange(1.0, SIZE)
    power, ends = np.zeros(SIZE - 1), 4 / SIZE * np.cos(math.pi * k / (2 * SIZE)) ** 2
    for t in model:
        if t.row.waveform is None:
            row = t.sampled(RATE)
            power += t.power(RATE) * (row.dct(k, SIZE) + (row.edge + row.ends) * ends)
    return al.expected(model, "oadev", np.array(OCTAVES) / RATE, rate=RATE, size=SIZE), bands(power)


def main() -> None:
    run = begin(__doc__, records=200)
    rows, every = [], []
    for (name,), made in spread(simulated, zip(MODELS), run.asked.records):
        seen = np.array(made)
        z = (seen.mean(axis=0) - expected(name)) / (seen.std(axis=0, ddof=1) / math.sqrt(run.asked.records))
        for what, each in zip(("oadev", "spectrum"), z, strict=True):
            rows.append((name, what, *(f"{value:+.2f}" for value in each), f"{np.abs(each).max():.2f}"))
        every.append(z)
    z = np.array(every)
    notes = [
        f"{SEEDS}; {run.asked.records} records of {SIZE} readings at {RATE:g} Hz",
        "cells: (mean over the records - exact expectation) / standard error of the mean. of oadev: at averaging "
        "factors; of spectrum: mean power of the cosine transform's coefficients k to 2k - 1, noise terms alone.",
        f"beyond 3 standard errors: {int((np.abs(z) > 3).sum())} of {z.size} cells ({0.0027 * z.size:.1f} are "
        f"expected of correct ones); their root mean square is {math.sqrt((z**2).mean()):.3f}",
    ]
    run.publish("Simulated records against their expectation", notes, markdown(HEADINGS, rows))


if __name__ == "__main__":
    main()

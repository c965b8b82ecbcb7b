"""Drift without aid: closed form against a strapdown integration of simulated sensors.

Three gyros and three accelerometers at rest, from the independent simulator; the bias of each is its mean over a minute
before. Rates turn the attitude as rotation vectors, specific forces are turned and integrated twice. Then the
intervals of the heading from records of 2 h, whose noise is identified.
"""

from table import SEEDS, begin, coefficients, section, seeded, spread

import math
from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

import allanite as al
from judge import sensor

NOISES = {
    "N": ("N 0.05 deg/sqrt(h)", "N 50 ug/sqrt(Hz)"), "B": ("B 0.5 deg/h", "B 20 ug"),
    "K": ("K 1 deg/h/sqrt(h)", "K 50 ug/sqrt(h)"), "GM": ("GM 1 deg/h 100 s", "GM 50 ug 100 s"),
    "R": ("R 0.5 deg/h^2", "R 100 ug/h"),
}  # fmt: skip
SENSORS = ("N", "N B", "N K", "N B K", "N GM", "N B K R")
CALIBRATION = 60.0
SPANS = ((20.0, (1.0, 10.0)), (1.0, (60.0, 600.0, 3600.0)))
"""Sampling rate, Hz, and the times without aid, s, that are read from its runs."""
TIMES = [t for _, span in SPANS for t in span]
QUANTITIES = {"heading": "deg", "attitude": "deg", "velocity": "m/s", "position": "m"}
GRAVITY, RADIUS = 9.80665, 6_371_008.8
BATCH = 100  # runs that are integrated together
ENDS = ("", ", B 7 deg/h", ", K 20 deg/h/sqrt(h)", ", B 7 deg/h, K 20 deg/h/sqrt(h)")
IDENTIFIED = tuple(f"N 0.3 deg/sqrt(h){end}" for end in ENDS)
LENGTH = 36_000, 5.0  # samples and sampling rate, Hz, of the records whose noise is identified

Errors = dict[str, np.ndarray]


def models(sensor: str) -> list[al.Model]:
    """The noise of the gyros and of the accelerometers."""
    return [al.Model(", ".join(NOISES[symbol][i] for symbol in sensor.split())) for i in (0, 1)]


def samples(model: al.Model, rate: float, last: float, rng: np.random.Generator) -> np.ndarray:
    """Errors after the calibration, less their mean during it, shape (runs, 3, samples)."""
    before, n = round(CALIBRATION * rate), round((CALIBRATION + last) * rate)
    noise = coefficients(model)
    made = np.array([sensor(n, rate, rng, **noise) for _ in range(3 * BATCH)])
    return (made[:, before:] - made[:, :before].mean(axis=1, keepdims=True)).reshape(BATCH, 3, -1)


def strapdown(gyro: np.ndarray, force: np.ndarray, dt: float) -> Iterator[Errors]:
    """Errors after each sample: of the yaw, of roll and pitch, of horizontal velocity and position."""
    attitude = np.broadcast_to(np.eye(3), (len(gyro), 3, 3))
    velocity, position = np.zeros((2, len(gyro), 3))
    down = np.array([0.0, 0.0, GRAVITY])
    for rate, felt in zip(np.moveaxis(gyro, 2, 0), np.moveaxis(force, 2, 0), strict=True):
        after = attitude @ Rotation.from_rotvec(rate * dt).as_matrix()
        moved = ((attitude + after) / 2 @ (felt + down)[:, :, None])[:, :, 0] - down
        position = position + velocity * dt + moved * dt**2 / 2
        velocity, attitude = velocity + moved * dt, after
        yaw = np.arctan2(attitude[:, 1, 0], attitude[:, 0, 0])
        tilt = np.arcsin(np.stack([attitude[:, 2, 1], attitude[:, 2, 0]]))
        yield {"heading": yaw, "attitude": tilt, "velocity": velocity[:, :2], "position": position[:, :2]}


def round_earth(gyro: np.ndarray, force: np.ndarray, dt: float) -> Iterator[Errors]:
    """Tilt, velocity and position of the Schuler loop of one axis after each sample: tilt' = rate - velocity / R."""
    tilt, velocity, position = np.zeros((3, *gyro.shape[:2]))
    for rate, felt in zip(np.moveaxis(gyro, 2, 0), np.moveaxis(force, 2, 0), strict=True):
        before, middle = tilt, velocity + dt / 2 * (GRAVITY * tilt + felt)
        tilt = tilt + dt * (rate - middle / RADIUS)
        faster = velocity + dt * (GRAVITY * (before + tilt) / 2 + felt)
        position, velocity = position + dt * (velocity + faster) / 2, faster
        yield {"attitude": tilt, "velocity": velocity, "position": position}


def squares(job: tuple[str, bool, int]) -> Errors:
    """Mean squares of the errors of a batch of runs at all times, SI."""
    noise, schuler, number = job
    rng, found = seeded(number, noise, schuler), []
    for rate, times in SPANS:
        rates, forces = (samples(model, rate, times[-1], rng) for model in models(noise))
        course = (round_earth if schuler else strapdown)(rates, forces, 1 / rate)
        found += [errors for k, errors in enumerate(course, 1) if k / rate in times]
    return {name: np.array([np.mean(errors[name] ** 2) for errors in found]) for name in found[0]}


def predicted(sensor: str, *, schuler: bool = False) -> al.Drift:
    """The closed form."""
    return al.drift(models(sensor), times=TIMES, calibration=CALIBRATION, schuler=schuler)


def compared(noise: str, schuler: bool, batches: list[Errors]) -> list[list[str]]:
    """A row for each quantity: the closed form at each time, and how far the simulation is from it."""
    drift, rows = predicted(noise, schuler=schuler), []
    for name, unit in ((name, QUANTITIES[name]) for name in batches[0]):
        course = drift[name]
        off = 100 * (np.sqrt(np.mean([batch[name] for batch in batches], axis=0)) / course.sigma - 1)
        pairs = zip(course.to(unit).tolist(), off.tolist(), strict=True)
        rows.append([noise, name, unit, *(f"{sigma:.4g} ({part:+.2f} %)" for sigma, part in pairs)])
    return rows


def covers(job: tuple[str, int]) -> np.ndarray | None:
    """At each time whether interval and upper limit are right about the heading, and the estimate over the truth."""
    text, number = job
    model, (size, rate) = al.Model(text), LENGTH
    truth = al.drift(model, calibration=CALIBRATION)["heading"].sigma
    fit = al.identify(al.Record(sensor(size, rate, seeded(number, text), **coefficients(model)), rate, "rad/s"))
    if fit.valid is None:
        return None
    found = al.drift(fit, calibration=CALIBRATION)["heading"]
    return np.array([(found.low <= truth) & (truth <= found.high), truth <= found.most, found.sigma / truth])


def interval_row(text: str, made: list[np.ndarray | None]) -> list[str]:
    """Shares of records in which they are, and the median estimate."""
    kept = np.array([each for each in made if each is not None])
    shares, ratio = 100 * kept[:, :2].mean(axis=0), np.median(kept[:, 2], axis=0)
    return [text, str(len(kept)), *(f"{a:.0f}, {b:.0f}, {r:.2f}" for a, b, r in zip(*shares, ratio, strict=True))]


def main() -> None:
    run = begin(__doc__, runs=3000, records=200)
    runs = run.asked.runs
    times = [f"{t:g} s" for t in TIMES]
    heads, rows = ["noise", "quantity", "unit", *times], {False: [], True: []}
    for cell, made in spread(squares, [*((noise, False) for noise in SENSORS), (SENSORS[-1], True)], runs // BATCH):
        rows[cell[1]] += compared(*cell, made)
    intervals = [interval_row(*cell, made) for cell, made in spread(covers, zip(IDENTIFIED), run.asked.records)]
    errors, share = [100 / math.sqrt(2 * runs * axes) for axes in (1, 2)], 100 * math.sqrt(0.0475 / run.asked.records)
    body = section("Strapdown, flat earth", heads, rows[False])
    body += section("Round earth", heads, rows[True],
                    "Each axis by itself: the tilt falls by the velocity over the earth's radius.")  # fmt: skip
    body += section("Intervals of the heading", ("noise", "records", *times), intervals, "From identified noise: share "
                    "of records whose 95 % interval has the truth, share whose upper limit is above it, %, and median "
                    "of estimate over truth.")  # fmt: skip
    notes = [
        f"{SEEDS}, which is of {BATCH} runs in the first two tables",
        f"{runs} runs a row; Monte-Carlo standard error {errors[0]:.2f} % of heading, {errors[1]:.2f} % of the others, "
        f"which are of two axes (of three on the round earth); of a share of 95 % of {run.asked.records} records "
        f"{share:.1f} %",
        f"noise of gyros and accelerometers: {'; '.join(f'{g} and {a}' for g, a in NOISES.values())}; calibration "
        f"{CALIBRATION:g} s",
        "standard deviation in closed form, and by how much the simulated one differs from it",
    ]
    run.publish("Drift without aid", notes, body)


if __name__ == "__main__":
    main()

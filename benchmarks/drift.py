"""Drift without aid: closed form against a strapdown integration of simulated sensors.

Three gyros and three accelerometers at rest; the bias of each is its mean over a minute before. Rates turn the attitude
by Rodrigues' formula, specific forces are turned and integrated twice. Then the intervals of the heading from records
of 2 h, whose noise is identified. Random numbers have seeds 1, 2, 3 ...
"""

from table import begin, section

import math

import numpy as np

import allanite as al

NOISES = {
    "N": ("N 0.05 deg/sqrt(h)", "N 50 ug/sqrt(Hz)"),
    "B": ("B 0.5 deg/h", "B 20 ug"),
    "K": ("K 1 deg/h/sqrt(h)", "K 50 ug/sqrt(h)"),
    "GM": ("GM 1 deg/h 100 s", "GM 50 ug 100 s"),
    "R": ("R 0.5 deg/h^2", "R 100 ug/h"),
}
SENSORS = ("N", "N B", "N K", "N B K", "N GM", "N B K R")
CALIBRATION = 60.0
SPANS = ((20.0, (1.0, 10.0)), (1.0, (60.0, 600.0, 3600.0)))
"""Sampling rate, Hz, and the times without aid, s, that are read from its runs."""
QUANTITIES = {"heading": "deg", "attitude": "deg", "velocity": "m/s", "position": "m"}
GRAVITY, RADIUS = 9.80665, 6_371_008.8
BATCH = 250
IDENTIFIED = tuple(
    f"N 0.3 deg/sqrt(h){more}"
    for more in ("", ", B 7 deg/h", ", K 20 deg/h/sqrt(h)", ", B 7 deg/h, K 20 deg/h/sqrt(h)")
)
LENGTH = 36_000, 5.0  # samples and sampling rate, Hz, of the records whose noise is identified


def models(sensor: str) -> list[al.Model]:
    """The noise of the gyros and of the accelerometers."""
    return [al.Model(", ".join(NOISES[symbol][i] for symbol in sensor.split())) for i in (0, 1)]


def samples(model: al.Model, count: int, rate: float, last: float, rng: np.random.Generator) -> np.ndarray:
    """Errors after the calibration, less their mean during it, shape (runs, 3, samples)."""
    before, n = round(CALIBRATION * rate), round((CALIBRATION + last) * rate)
    found = np.array([al.simulate(model, n, rate, rng=rng).rate_values for _ in range(3 * count)])
    return (found[:, before:] - found[:, :before].mean(axis=1, keepdims=True)).reshape(count, 3, -1)


def turned(attitude: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Attitudes, shape (runs, 3, 3), after a rotation by a vector in the axes of the body."""
    angle = np.linalg.norm(vector, axis=1)[:, None, None]
    x, y, z = vector.T
    zero = np.zeros_like(x)
    cross = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    safe = np.where(angle > 0, angle, 1.0)
    step = np.eye(3) + np.sin(angle) / safe * cross + (1 - np.cos(angle)) / safe**2 * (cross @ cross)
    return attitude @ step


def strapdown(gyro: np.ndarray, force: np.ndarray, rate: float, times: tuple[float, ...]) -> dict[str, np.ndarray]:
    """Mean squares of the errors at the times: of the yaw, of roll and pitch, of horizontal velocity and position."""
    runs, dt = len(gyro), 1 / rate
    attitude = np.broadcast_to(np.eye(3), (runs, 3, 3))
    velocity, position = np.zeros((runs, 3)), np.zeros((runs, 3))
    down = np.array([0.0, 0.0, GRAVITY])
    steps = [round(t * rate) for t in times]
    found: dict[str, list[float]] = {name: [] for name in QUANTITIES}
    for k in range(steps[-1]):
        after = turned(attitude, gyro[:, :, k] * dt)
        felt = ((attitude + after) / 2 @ (force[:, :, k] + down)[:, :, None])[:, :, 0] - down
        position += velocity * dt + felt * dt**2 / 2
        velocity += felt * dt
        attitude = after
        if k + 1 in steps:
            yaw = np.arctan2(attitude[:, 1, 0], attitude[:, 0, 0])
            tilt = np.arcsin(np.stack([attitude[:, 2, 1], attitude[:, 2, 0]]))
            errors = (yaw, tilt, velocity[:, :2], position[:, :2])
            for name, error in zip(QUANTITIES, errors, strict=True):
                found[name].append(float(np.mean(error**2)))
    return {name: np.array(values) for name, values in found.items()}


def round_earth(gyro: np.ndarray, force: np.ndarray, rate: float, times: tuple[float, ...]) -> dict[str, np.ndarray]:
    """Mean squares of tilt, velocity and position of the Schuler loop of one axis: tilt' = rate - velocity / R."""
    dt, steps = 1 / rate, [round(t * rate) for t in times]
    tilt, velocity, position = (np.zeros(gyro.shape[:2]) for _ in range(3))
    found: dict[str, list[float]] = {name: [] for name in ("attitude", "velocity", "position")}
    for k in range(steps[-1]):
        middle = velocity + dt / 2 * (GRAVITY * tilt + force[:, :, k])
        before = tilt
        tilt = tilt + dt * (gyro[:, :, k] - middle / RADIUS)
        faster = velocity + dt * (GRAVITY * (before + tilt) / 2 + force[:, :, k])
        position, velocity = position + dt * (velocity + faster) / 2, faster
        if k + 1 in steps:
            for name, error in zip(found, (tilt, velocity, position), strict=True):
                found[name].append(float(np.mean(error**2)))
    return {name: np.array(values) for name, values in found.items()}


def simulated(sensor: str, runs: int, seed: int, integrate=strapdown) -> dict[str, np.ndarray]:
    """Root mean squares of the errors of all runs at all times, SI."""
    gyro, accelerometer = models(sensor)
    rng, sums = np.random.default_rng(seed), {}
    for rate, times in SPANS:
        for start in range(0, runs, BATCH):
            count = min(BATCH, runs - start)
            rates, forces = (samples(model, count, rate, times[-1], rng) for model in (gyro, accelerometer))
            for name, squares in integrate(rates, forces, rate, times).items():
                sums[rate, name] = sums.get((rate, name), 0.0) + squares * count / runs
    names = dict.fromkeys(name for _, name in sums)
    return {name: np.sqrt(np.concatenate([sums[rate, name] for rate, _ in SPANS])) for name in names}


def predicted(sensor: str, *, schuler: bool = False) -> al.Drift:
    """The closed form."""
    times = [t for _, span in SPANS for t in span]
    return al.drift(models(sensor), times=times, calibration=CALIBRATION, schuler=schuler)


def compared(sensor: str, runs: int, seed: int, *, schuler: bool = False) -> list[list[str]]:
    """A row for each quantity: the closed form at each time, and how far the simulation is from it."""
    found = simulated(sensor, runs, seed, round_earth if schuler else strapdown)
    drift = predicted(sensor, schuler=schuler)
    rows = []
    for name, rms in found.items():
        course, unit = drift[name], QUANTITIES[name]
        off = 100 * (rms / course.sigma - 1)
        pairs = zip(course.to(unit).tolist(), off.tolist(), strict=True)
        rows.append([sensor, name, unit, *(f"{sigma:.4g} ({part:+.2f} %)" for sigma, part in pairs)])
    return rows


def covered(text: str, records: int) -> list[list[str]]:
    """Shares of records whose interval, and whose upper limit, is right about the heading, and the median estimate."""
    model, (size, rate) = al.Model(text), LENGTH
    truth = al.drift(model, calibration=CALIBRATION)["heading"].sigma
    fits = (al.identify(al.simulate(model, size, rate, rng=seed)) for seed in range(1, records + 1))
    found = [al.drift(fit, calibration=CALIBRATION)["heading"] for fit in fits if fit.valid is not None]
    inside = np.mean([(c.low <= truth) & (truth <= c.high) for c in found], axis=0)
    below = np.mean([truth <= c.most for c in found], axis=0)
    ratio = np.median([c.sigma / truth for c in found], axis=0)
    cells = [f"{100 * a:.0f}, {100 * b:.0f}, {r:.2f}" for a, b, r in zip(inside, below, ratio, strict=True)]
    return [[text, str(len(found)), *cells]]


def main() -> None:
    run = begin(__doc__, runs=6000, records=100)
    runs = run.asked.runs
    times = [f"{t:g} s" for _, span in SPANS for t in span]
    heads = ["noise", "quantity", "unit", *times]
    errors = [100 / math.sqrt(2 * runs * axes) for axes in (1, 2)]
    flat = [row for seed, sensor in enumerate(SENSORS, 1) for row in compared(sensor, runs, seed)]
    body = section("Strapdown, flat earth", heads, flat)
    body += section("Round earth", heads, compared(SENSORS[-1], runs, len(SENSORS) + 1, schuler=True),
                    "Each axis by itself: the tilt falls by the velocity over the earth's radius.")  # fmt: skip
    rows = [row for text in IDENTIFIED for row in covered(text, run.asked.records)]
    body += section("Intervals of the heading", ("noise", "records", *times), rows, "From identified noise: share of "
                    "records whose 95 % interval has the truth, share whose upper limit is above it, %, and median of "
                    "estimate over truth.")  # fmt: skip
    notes = [
        f"{runs} runs a row, seeds 1, 2, 3 ...; Monte-Carlo standard error {errors[0]:.2f} % of heading, "
        f"{errors[1]:.2f} % of the others, which are of two axes (of three on the round earth)",
        f"noise of gyros and accelerometers: {'; '.join(f'{g} and {a}' for g, a in NOISES.values())}; calibration "
        f"{CALIBRATION:g} s",
        "standard deviation in closed form, and by how much the simulated one differs from it",
    ]
    run.publish("Drift without aid", notes, body)


if __name__ == "__main__":
    main()

"""What `check` says of simulators and of claimed filters: defects and wrong cut-offs it finds, and its false alarms.

Four simulators are written out as their sources have them: the files that configure them are the claims. The recursion
of a bias, b = phi b + s w, is that of a filter. Each of the defects is put into one of them; right records are those of
the simulators without a defect. Then white noise behind a filter, or none, is held against its own cut-off and others.
"""

from table import SEEDS, Row, begin, section, seeded, spread

import math
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.signal import bessel, butter, lfilter

import allanite as al
from allanite.claims.checking import check, setting_rows
from allanite.claims.claim import CUTOFF, ClaimedSetting, claim_of
from allanite.claims.result import DIFFERS, NOT_DECIDED

RATE, SIZE = 100.0, 360_000
Rng = np.random.Generator
Draw = Callable[[Rng, int], np.ndarray]
NORMAL, UNIFORM = Rng.standard_normal, Rng.random  # randn() and rand(), which is between 0 and 1


@dataclass(frozen=True)
class Sensor:
    """What a configuration says of a sensor, and what its simulator does with it.

    `white` and `drive` draw numbers, which `sigma` and `bias` scale at a sample interval; `time` is the correlation
    time that is used.
    """

    density: float
    walk: float
    time: float = math.inf
    white: Draw = NORMAL
    drive: Draw = NORMAL
    sigma: Callable[["Sensor", float], float] = lambda s, dt: s.density / math.sqrt(dt)
    bias: Callable[["Sensor", float], float] = lambda s, dt: (
        s.walk * math.sqrt(dt if math.isinf(s.time) else -s.time / 2 * math.expm1(-2 * dt / s.time))
    )
    added: bool = True
    scale: float = 1.0

    def samples(self, rng: Rng) -> np.ndarray:
        """The output of one axis at rest."""
        dt = 1 / RATE
        rates = self.sigma(self, dt) * self.white(rng, SIZE)
        if self.added:
            rates += lfilter([self.bias(self, dt)], [1.0, -math.exp(-dt / self.time)], self.drive(rng, SIZE))
        return self.scale * rates


PLUGIN = '<plugin name="imu_plugin" filename="libgazebo_imu_plugin.so">'
NOISE = (
    '<noise type="gaussian"><mean>0</mean><stddev>{deviation!r}</stddev>'
    "<dynamic_bias_stddev>{of.walk!r}</dynamic_bias_stddev>"
    "<dynamic_bias_correlation_time>{of.time!r}</dynamic_bias_correlation_time></noise>"
)
SENSORS = ("gyroscope", "accelerometer")
FORMS = {
    # the IMU plugin of gazebo-classic, as RotorS and the SITL of PX4 have it
    "gazebo-classic": (
        PLUGIN, "</plugin>", "\n", SENSORS,
        "<{name}NoiseDensity>{of.density!r}</{name}NoiseDensity><{name}RandomWalk>{of.walk!r}</{name}RandomWalk>"
        "<{name}BiasCorrelationTime>{of.time!r}</{name}BiasCorrelationTime>",
    ),
    # gz-sensors: a standard deviation per sample
    "gazebo": (
        "<imu>", "</imu>", "", ("angular_velocity", "linear_acceleration"),
        "<{name}>" + "".join(f"<{axis}>{NOISE}</{axis}>" for axis in "xyz") + "</{name}>",
    ),
    "pegasus": (
        "{", f', "update_rate": {RATE}}}', ", ", SENSORS,
        '"{name}": {{"noise_density": {of.density!r}, "random_walk": {of.walk!r}, '
        '"bias_correlation_time": {of.time!r}}}',
    ),
    "kalibr": ("", "", "\n", SENSORS, "{name}_noise_density: {of.density!r}\n{name}_random_walk: {of.walk!r}"),
}  # fmt: skip
"""How programs write their noise: what stands before, behind and between sensors, their names, and that of each."""


@dataclass(frozen=True)
class Simulator:
    """The form of a configuration, the gyro and accelerometer that it describes, and those that are simulated."""

    form: str
    claimed: tuple[Sensor, Sensor]
    simulated: tuple[Sensor, Sensor]

    def claim(self) -> object:
        """What its file claims, recognized by its fields."""
        before, after, between, names, each = FORMS[self.form]
        sensors = [
            each.format(name=name, of=of, deviation=of.density * math.sqrt(RATE))
            for name, of in zip(names, self.claimed, strict=True)
        ]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "noise.txt"
            path.write_text(before + between.join(sensors) + after)
            return claim_of(path, rate=RATE)

    def check(self, rng: Rng, axes: str) -> "al.claims.ClaimCheck":
        """What is said of a record at rest of these axes: g for one of the gyro, a for one of the accelerometer."""
        sensors = dict(zip("ga", zip(self.simulated, ("rad/s", "m/s^2"), strict=True), strict=True))
        made = ((*sensors[letter], f"{letter}{i}") for i, letter in enumerate(axes))
        records = (al.Record(of.samples(rng), RATE, unit, name=name) for of, unit, name in made)
        return check(al.Recording(tuple(records)), self.claim())


def right(name: str, pair: tuple[Sensor, Sensor], **changes: object) -> Simulator:
    """A simulator that does what its configuration says, but for changes of the gyro."""
    return Simulator(name, pair, (replace(pair[0], **changes), pair[1]))


SITL = Sensor(1.8665e-4, 3.8785e-5, 1000.0), Sensor(1.86e-3, 6e-3, 300.0)
SHIPPED = Sensor(3.394e-4, 3.8785e-5, 1000.0), Sensor(4e-3, 6e-3, 300.0)
ADIS16448 = Sensor(1.6968e-4, 1.9393e-5), Sensor(2e-3, 3e-3)
SHORT = Sensor(3.394e-4, 3.8785e-5, 300.0), Sensor(4e-3, 6e-3, 30.0)
QUIET = Sensor(1.7e-5, 0.0), Sensor(1.7e-3, 0.0)

CLAIMED = {"kalibr": ADIS16448, "gazebo": SITL, "pegasus": SHIPPED, "gazebo-classic": SITL}
RIGHT = {name: right(name, pair) for name, pair in CLAIMED.items()}


def wrong(name: str, pair: tuple[Sensor, Sensor] | None = None, **changes: object) -> Simulator:
    """A simulator whose sensors differ from its configuration."""
    described = pair or CLAIMED[name]
    return Simulator(name, described, tuple(replace(sensor, **changes) for sensor in described))


DEFECTS = {
    "correlation time of the accelerometer in the gyro, 300 s and 30 s": ("PegasusSimulator#148",
           right("pegasus", SHORT, time=SHORT[1].time), "correlation time of the other"),
    "the same with the shipped times, 1000 s and 300 s": ("PegasusSimulator#148",
           right("pegasus", SHIPPED, time=SHIPPED[1].time), "correlation time of the other"),
    "bias driven by rand()": ("PegasusSimulator#148", wrong("pegasus", drive=UNIFORM),
           "driven by rand()"),
    "white noise by rand() - 0.5": ("rand for randn",
           wrong("pegasus", white=lambda rng, n: rng.random(n) - 0.5), "rand() instead of randn()"),
    "white noise by rand(): the mean is not zero": ("rand for randn", wrong("kalibr", white=UNIFORM),
           "mean is not zero"),
    "bias never added": ("PegasusSimulator#148", wrong("pegasus", added=False), "may not have added it"),
    "density taken for the deviation of a sample": ("PX4-gazebo-models#33",
           wrong("gazebo-classic", sigma=lambda s, dt: s.density), "value per sample"),
    "white noise 300 times": ("PX4-SITL_gazebo-classic#73",
           right("gazebo-classic", SITL, sigma=lambda s, dt: 300 * s.density / math.sqrt(dt)), "300"),
    "white noise times sqrt(dt): depends on the rate": ("rosflight_ros_pkgs#254",
           wrong("gazebo-classic", sigma=lambda s, dt: s.density * math.sqrt(dt)), "depends on the rate"),
    "degrees for radians": ("units", right("kalibr", ADIS16448, scale=180 / math.pi), "degrees and radians"),
    "deviation squared: variance for deviation": ("mir_robot#99",
           wrong("gazebo", QUIET, sigma=lambda s, dt: s.density**2 / dt), "is squared"),
    "random walk per sample, without sqrt(dt)": ("gnss-ins-sim#19",
           wrong("kalibr", bias=lambda s, dt: s.walk), "value per sample"),
    "sqrt(h) read as sqrt(s)": ("units",
           right("kalibr", ADIS16448, sigma=lambda s, dt: 60 * s.density / math.sqrt(dt)), "sqrt(h) and"),
    "deviation of the bias for its density": ("gz-sensors#616",
           wrong("gazebo", bias=lambda s, dt: s.walk * math.sqrt(-math.expm1(-2 * dt / s.time))),
           "standard deviation of the bias"),
}  # fmt: skip
"""Where a defect was seen, the simulator with it, and what the cause must say."""


def defect(job: tuple[str, int]) -> tuple[bool, bool]:
    """Whether a defect is found in a record of three axes of each sensor, and its cause named."""
    name, number = job
    _, simulator, wanted = DEFECTS[name]
    verdict = simulator.check(seeded(number, name), "gggaaa")
    said = [sentence for cause in verdict.causes for sentence in cause.sentences if sentence]
    return not verdict.agrees, any(wanted in sentence for sentence in said)


def alarm(job: tuple[str, int]) -> bool:
    """Whether a right record is contradicted."""
    name, number = job
    return not RIGHT[name].check(seeded(number, "right", name), "ga").agrees


Filter = tuple[np.ndarray, np.ndarray]
SAMPLED, LENGTH, START = 200.0, 20_000, 1000
"""Sampling rate of filtered noise, Hz, its samples, and those before, in which a filter settles."""
FACTORS = {"true": 1.0, "0.8 times": 0.8, "1.25 times": 1.25, "half": 0.5, "twice": 2.0}
ABSENT = (20.0, 42.0, 60.0, 80.0, 88.0)  # cut-offs, Hz, that are claimed where no filter is


def poles(order: int, cutoff: float) -> Filter:
    """RC filters one behind the other, their cut-off in cycles a sample."""
    p = math.exp(-2 * math.pi * cutoff)
    return np.array([(1 - p) ** order]), np.poly([p] * order)


FILTERS: dict[str, tuple[Filter, float]] = {
    "RC": (poles(1, 0.15), 30.0),
    "Butterworth of order 2": (butter(2, 42.0, fs=SAMPLED), 42.0),
    "moving average of 4 samples": ((np.full(4, 0.25), np.ones(1)), 0.443 / 4 * SAMPLED),
}
"""Filters that are rows of the table of filters, and their cut-offs, Hz."""
OTHERS: dict[str, tuple[Filter, float]] = {
    "RC twice": (poles(2, 0.12), 16.0),
    "RC three times": (poles(3, 0.12), 12.6),
    "Bessel of order 2": (bessel(2, 42.0, norm="mag", fs=SAMPLED), 42.0),
    "Butterworth of order 4": (butter(4, 42.0, fs=SAMPLED), 42.0),
}
"""Filters that are not; their samples are rounded to a fourth of a deviation."""
NONE: dict[str, tuple[Filter, float]] = {"no filter": ((np.ones(1), np.ones(1)), 0.0)}


def outcomes(job: tuple[str, int]) -> list[str]:
    """What is said of each claimed cut-off of one record."""
    name, number = job
    through, cutoff = (FILTERS | OTHERS | NONE)[name]
    y = lfilter(*through, 1e-3 * seeded(number, name).standard_normal(LENGTH + START))[START:]
    step = y.std() / 4
    study = al.analyze(al.Record(step * np.round(y / step) if name in OTHERS else y, SAMPLED, "rad/s", name="gx"))
    claimed = [factor * cutoff for factor in FACTORS.values()] if cutoff else ABSENT
    return [next(setting_rows(study, [ClaimedSetting(CUTOFF, c)], 0.05, 0.02)).outcome for c in claimed]


def filter_rows(filters: Iterable[str], records: int) -> list[Row]:
    """How often each claim is contradicted, and how often it is not decided on."""
    rows = []
    for cell, said in spread(outcomes, zip(filters), records):
        counts = map(Counter, zip(*said, strict=True))
        rows.append((*cell, str(records), *(f"{count[DIFFERS]} ({count[NOT_DECIDED]})" for count in counts)))
    return rows


def main() -> None:
    run = begin(__doc__, records=5, right=100, filters=40, others=10)
    n, right, filters, others = (getattr(run.asked, name) for name in ("records", "right", "filters", "others"))
    sums = {name: np.sum(made, axis=0) for (name,), made in spread(defect, zip(DEFECTS), n)}
    defects = [(name, DEFECTS[name][0], *(f"{count} of {n}" for count in counts)) for name, counts in sums.items()]
    found, named = np.array(list(sums.values())).T
    alarms = {name: sum(made) for (name,), made in spread(alarm, zip(RIGHT), right)}
    rights = [(name, str(right), str(count), f"{100 * count / right:.1f} %") for name, count in alarms.items()]
    known, wrongly, records = filter_rows(FILTERS, filters), sum(alarms.values()), right * len(alarms)
    notes = (
        SEEDS,
        f"simulators: 1 h at {RATE:g} Hz; three axes of each sensor with a defect, one of each without",
        f"found in every record: {sum(found == n)} of {len(found)} defects; cause named in more than half of the "
        f"records: {sum(named > n / 2)} of {len(found)}",
        f"false alarms: {wrongly} of {records} right records, {100 * wrongly / records:.1f} %",
        f"false alarms at the true cut-off: {sum(int(row[2].split()[0]) for row in known)} of {filters * len(known)} "
        "records, nominal 5 %",
    )
    heads, absent = ("filter", "records", *FACTORS), ("filter", "records", *(f"{c:g} Hz" for c in ABSENT))
    filtered = f"White noise, {LENGTH} samples at {SAMPLED:g} Hz; contradicted, and in brackets not decided."
    body = section("Defects", ("defect", "seen in", "found", "cause named"), defects)
    body += section("Right records", ("simulator", "records", "false alarms", "share"), rights)
    body += section("Filters that are rows", heads, known, filtered)
    body += section("No filter", absent, filter_rows(NONE, filters))
    rounded = "Rounded to a fourth of the standard deviation."
    body += section("Filters of no row", heads, filter_rows(OTHERS, others), rounded)
    run.publish("Check of simulators and filters against what is claimed of them", notes, body)


if __name__ == "__main__":
    main()

"""What `check` says of simulators and of claimed filters: defects and wrong cut-offs it finds, and its false alarms.

Four simulators are written out as their sources have them: the files that configure them are the claims. The recursion
of a bias, b = phi b + s w, is that of a filter. Each of the defects is put into one of them; right records are those of
the simulators without a defect. Then white noise behind a filter, or none, is held against its own cut-off and others.
"""

from table import SEEDS, begin, section, seeded, spread

import math
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.signal import bessel, butter, lfilter

import allanite as al
from allanite.claims.checking import check, setting_rows
from allanite.claims.claim import CUTOFF, ClaimedSetting, claim_of

RATE, SIZE = 100.0, 360_000
Rng = np.random.Generator
Draw = Callable[[Rng, int], np.ndarray]


def normal(rng: Rng, n: int) -> np.ndarray:
    """randn()."""
    return rng.standard_normal(n)


def uniform(rng: Rng, n: int) -> np.ndarray:
    """rand(): between 0 and 1."""
    return rng.random(n)


@dataclass(frozen=True)
class Sensor:
    """What a configuration says of a sensor, and what its simulator does with it.

    `white` and `drive` draw numbers, which `sigma` and `bias` scale at a sample interval; `time` is the correlation
    time that is used.
    """

    density: float
    walk: float
    time: float = math.inf
    white: Draw = normal
    drive: Draw = normal
    sigma: Callable[["Sensor", float], float] = lambda s, dt: s.density / math.sqrt(dt)
    bias: Callable[["Sensor", float], float] = lambda s, dt: (
        s.walk * math.sqrt(dt if math.isinf(s.time) else -s.time / 2 * math.expm1(-2 * dt / s.time))
    )
    added: bool = True
    scale: float = 1.0

    @property
    def deviation(self) -> float:
        """Standard deviation of a sample."""
        return self.density * math.sqrt(RATE)

    def samples(self, rng: Rng) -> np.ndarray:
        """The output of one axis at rest."""
        dt = 1 / RATE
        rates = self.sigma(self, dt) * self.white(rng, SIZE)
        if self.added:
            bias = lfilter([self.bias(self, dt)], [1.0, -math.exp(-dt / self.time)], self.drive(rng, SIZE))
            rates = rates + bias
        return self.scale * rates


@dataclass(frozen=True)
class Form:
    """How a program writes its noise: what stands around two sensors, how each is written, and how they are called."""

    around: tuple[str, str, str]
    each: str
    names: tuple[str, str] = ("gyroscope", "accelerometer")


PLUGIN = '<plugin name="imu_plugin" filename="libgazebo_imu_plugin.so">'
GAZEBO = (
    '<noise type="gaussian"><mean>0</mean><stddev>{of.deviation!r}</stddev>'
    "<dynamic_bias_stddev>{of.walk!r}</dynamic_bias_stddev>"
    "<dynamic_bias_correlation_time>{of.time!r}</dynamic_bias_correlation_time></noise>"
)
FORMS = {
    # the IMU plugin of gazebo-classic, as RotorS and the SITL of PX4 have it
    "gazebo-classic": Form(
        (PLUGIN, "\n", "</plugin>"),
        "<{name}NoiseDensity>{of.density!r}</{name}NoiseDensity><{name}RandomWalk>{of.walk!r}</{name}RandomWalk>"
        "<{name}BiasCorrelationTime>{of.time!r}</{name}BiasCorrelationTime>",
    ),
    # the noise of gz-sensors: a standard deviation per sample
    "gazebo": Form(
        ("<imu>", "", "</imu>"),
        "<{name}>" + "".join(f"<{axis}>{GAZEBO}</{axis}>" for axis in "xyz") + "</{name}>",
        ("angular_velocity", "linear_acceleration"),
    ),
    "pegasus": Form(
        ("{", ", ", f', "update_rate": {RATE}}}'),
        '"{name}": {{"noise_density": {of.density!r}, "random_walk": {of.walk!r}, '
        '"bias_correlation_time": {of.time!r}}}',
    ),
    "kalibr": Form(("", "\n", ""), "{name}_noise_density: {of.density!r}\n{name}_random_walk: {of.walk!r}"),
}


@dataclass(frozen=True)
class Simulator:
    """The form of a configuration, the sensors that it describes, and those that are simulated."""

    name: str
    claimed: tuple[Sensor, Sensor]
    gyro: Sensor
    accelerometer: Sensor

    def claim(self) -> object:
        """What its file claims, recognized by its fields."""
        form = FORMS[self.name]
        before, between, after = form.around
        each = [form.each.format(name=name, of=of) for name, of in zip(form.names, self.claimed, strict=True)]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "noise.txt"
            path.write_text(before + between.join(each) + after)
            return claim_of(path, rate=RATE)

    def check(self, rng: Rng, axes: str) -> "al.claims.ClaimCheck":
        """What is said of a record at rest of these axes: g for one of the gyro, a for one of the accelerometer."""
        sensors = {"g": (self.gyro, "rad/s"), "a": (self.accelerometer, "m/s^2")}
        made = ((*sensors[letter], f"{letter}{i}") for i, letter in enumerate(axes))
        records = (al.Record(of.samples(rng), RATE, unit, name=name) for of, unit, name in made)
        return check(al.Recording(tuple(records)), self.claim())


def right(name: str, pair: tuple[Sensor, Sensor], **changes: object) -> Simulator:
    """A simulator that does what its configuration says, but for changes of the gyro."""
    return Simulator(name, pair, replace(pair[0], **changes), pair[1])


SITL = Sensor(1.8665e-4, 3.8785e-5, 1000.0), Sensor(1.86e-3, 6e-3, 300.0)
SHIPPED = Sensor(3.394e-4, 3.8785e-5, 1000.0), Sensor(4e-3, 6e-3, 300.0)
ADIS16448 = Sensor(1.6968e-4, 1.9393e-5), Sensor(2e-3, 3e-3)
SHORT = Sensor(3.394e-4, 3.8785e-5, 300.0), Sensor(4e-3, 6e-3, 30.0)
QUIET = Sensor(1.7e-5, 0.0), Sensor(1.7e-3, 0.0)

RIGHT = {
    row.name: row
    for row in (
        right("kalibr", ADIS16448), right("gazebo", SITL), right("pegasus", SHIPPED), right("gazebo-classic", SITL),
    )
}  # fmt: skip


def wrong(name: str, pair: tuple[Sensor, Sensor] | None = None, **changes: object) -> Simulator:
    """A simulator whose sensors differ from its configuration."""
    made = right(name, pair or RIGHT[name].claimed, **changes)
    return replace(made, accelerometer=replace(made.accelerometer, **changes))


@dataclass(frozen=True)
class Defect:
    """A defect: where it was seen, the simulator with it, and what the cause must say."""

    name: str
    seen: str
    simulator: Simulator
    cause: str


DEFECTS = (
    Defect("correlation time of the accelerometer in the gyro, 300 s and 30 s", "PegasusSimulator#148",
           right("pegasus", SHORT, time=SHORT[1].time), "correlation time of the other"),
    Defect("the same with the shipped times, 1000 s and 300 s", "PegasusSimulator#148",
           right("pegasus", SHIPPED, time=SHIPPED[1].time), "correlation time of the other"),
    Defect("bias driven by rand()", "PegasusSimulator#148", wrong("pegasus", drive=uniform),
           "driven by rand()"),
    Defect("white noise by rand() - 0.5", "rand for randn",
           wrong("pegasus", white=lambda rng, n: rng.random(n) - 0.5), "rand() instead of randn()"),
    Defect("white noise by rand(): the mean is not zero", "rand for randn", wrong("kalibr", white=uniform),
           "mean is not zero"),
    Defect("bias never added", "PegasusSimulator#148", wrong("pegasus", added=False), "bias is not added"),
    Defect("density taken for the deviation of a sample", "PX4-gazebo-models#33",
           wrong("gazebo-classic", sigma=lambda s, dt: s.density), "value per sample"),
    Defect("white noise 300 times", "PX4-SITL_gazebo-classic#73",
           right("gazebo-classic", SITL, sigma=lambda s, dt: 300 * s.density / math.sqrt(dt)), "300"),
    Defect("white noise times sqrt(dt): depends on the rate", "rosflight_ros_pkgs#254",
           wrong("gazebo-classic", sigma=lambda s, dt: s.density * math.sqrt(dt)), "depends on the rate"),
    Defect("degrees for radians", "units", right("kalibr", ADIS16448, scale=180 / math.pi), "degrees and radians"),
    Defect("deviation squared: variance for deviation", "mir_robot#99",
           wrong("gazebo", QUIET, sigma=lambda s, dt: s.density**2 / dt), "is squared"),
    Defect("random walk per sample, without sqrt(dt)", "gnss-ins-sim#19",
           wrong("kalibr", bias=lambda s, dt: s.walk), "value per sample"),
    Defect("sqrt(h) read as sqrt(s)", "units",
           right("kalibr", ADIS16448, sigma=lambda s, dt: 60 * s.density / math.sqrt(dt)), "sqrt(h) and"),
    Defect("deviation of the bias for its density", "gz-sensors#616",
           wrong("gazebo", bias=lambda s, dt: s.walk * math.sqrt(-math.expm1(-2 * dt / s.time))),
           "standard deviation of the bias"),
)  # fmt: skip


def defect(job: tuple[int, int]) -> tuple[bool, bool, int]:
    """Whether a defect is found in a record of three axes of each sensor, its cause named, and how many are named."""
    which, number = job
    row = DEFECTS[which]
    verdict = row.simulator.check(seeded(number, row.name), "gggaaa")
    sentences = [sentence for cause in verdict.causes for sentence in cause.sentences if sentence]
    most = max((len(cause.names) for cause in verdict.causes), default=0)
    return not verdict.agrees, any(row.cause in sentence for sentence in sentences), most


def alarms(job: tuple[str, int]) -> list[str] | None:
    """Quantities of a right record that are contradicted, none if it agrees."""
    name, number = job
    verdict = RIGHT[name].check(seeded(number, "right", name), "ga")
    return None if verdict.agrees else [row.quantity for row in verdict.terms if row.contradicts]


Filter = tuple[np.ndarray, np.ndarray]
SAMPLED, LENGTH, START = 200.0, 20_000, 1000
"""Sampling rate of filtered noise, Hz, its samples, and those before, in which a filter settles."""
FACTORS = {"true": 1.0, "0.8 times": 0.8, "1.25 times": 1.25, "half": 0.5, "twice": 2.0}
ABSENT = (20.0, 42.0, 60.0, 80.0, 88.0)
"""Cut-offs, Hz, that are claimed where no filter is."""


def poles(order: int, cutoff: float) -> Filter:
    """RC filters one behind the other, their cut-off in cycles a sample."""
    p = math.exp(-2 * math.pi * cutoff)
    return np.array([(1 - p) ** order]), np.poly([p] * order)


FILTERS: dict[str, tuple[Filter, float]] = {
    "RC": (poles(1, 0.15), 30.0),
    "Butterworth of order 2": (butter(2, 42.0, fs=SAMPLED), 42.0),
    "moving average of 4 samples": ((np.full(4, 0.25), np.ones(1)), 0.443 / 4 * SAMPLED),
    "RC twice": (poles(2, 0.12), 16.0),
    "RC three times": (poles(3, 0.12), 12.6),
    "Bessel of order 2": (bessel(2, 42.0, norm="mag", fs=SAMPLED), 42.0),
    "Butterworth of order 4": (butter(4, 42.0, fs=SAMPLED), 42.0),
}
"""Filters and their cut-offs, Hz."""
ROWS = 3  # so many are rows of the table of filters; the samples of the others are rounded to a fourth of a deviation
NONE: Filter = (np.ones(1), np.ones(1))


def outcomes(job: tuple[str, int]) -> list[str]:
    """What is said of each claimed cut-off of one record."""
    name, number = job
    through, cutoff = FILTERS.get(name, (NONE, 1.0))
    y = lfilter(*through, 1e-3 * seeded(number, name).standard_normal(LENGTH + START))[START:]
    step = y.std() / 4
    rounded = name in list(FILTERS)[ROWS:]
    study = al.analyze(al.Record(step * np.round(y / step) if rounded else y, SAMPLED, "rad/s", name="gx"))
    claimed = [factor * cutoff for factor in FACTORS.values()] if name in FILTERS else ABSENT
    return [next(setting_rows(study, [ClaimedSetting(CUTOFF, c)], 0.05, 0.02)).outcome for c in claimed]


def filter_rows(names: list[str], records: int) -> list[list[str]]:
    """How often each claim is contradicted, and how often it is not decided on."""
    rows = []
    for (name,), said in spread(outcomes, [(name,) for name in names], records):
        counts = map(Counter, zip(*said, strict=True))
        rows.append([name, str(records), *(f"{count['differs']} ({count['not shown']})" for count in counts)])
        print(rows[-1], file=sys.stderr, flush=True)
    return rows


def share(count: int, of: int) -> str:
    """A count of a number of records."""
    return f"{count} of {of}"


def defect_rows(records: int) -> tuple[list[list[str]], str]:
    """A line for each defect, and in how many it and its cause are found."""
    rows, every, most = [], 0, 0
    for (which,), made in spread(defect, [(i,) for i in range(len(DEFECTS))], records):
        found, named, names = map(sum, zip(*made, strict=True))
        row, every, most = DEFECTS[which], every + (found == records), most + (named > records / 2)
        rows.append([row.name, row.seen, share(found, records), share(named, records), f"{names / records:.1f}"])
        print(rows[-1], file=sys.stderr, flush=True)
    count = len(DEFECTS)
    summary = (
        f"found in every record: {share(every, count)} defects; cause named in more than half of the records: "
        f"{share(most, count)}"
    )
    return rows, summary


def right_rows(records: int) -> tuple[list[list[str]], str]:
    """A line for each right simulator, and how many false alarms there are."""
    rows, total = [], 0
    for (name,), made in spread(alarms, [(name,) for name in RIGHT], records):
        kinds = Counter(kind for alarm in made if alarm is not None for kind in alarm)
        count = sum(alarm is not None for alarm in made)
        total += count
        listed = ", ".join(f"{kind} {times}" for kind, times in kinds.items())
        rows.append([name, str(records), str(count), f"{100 * count / records:.1f} %", listed])
        print(rows[-1], file=sys.stderr, flush=True)
    every = records * len(RIGHT)
    return rows, f"false alarms: {share(total, every)} right records, {100 * total / every:.1f} %"


def main() -> None:
    run = begin(__doc__, records=5, right=100, filters=40, others=10)
    defects, found = defect_rows(run.asked.records)
    rights, alarmed = right_rows(run.asked.right)
    known = filter_rows(list(FILTERS)[:ROWS], run.asked.filters)
    none = filter_rows(["no filter"], run.asked.filters)
    others = filter_rows(list(FILTERS)[ROWS:], run.asked.others)
    alarm = sum(int(row[2].split()[0]) for row in known)
    filtered = f"White noise, {LENGTH} samples at {SAMPLED:g} Hz; contradicted, and in brackets not decided."
    heads = ("filter", "records", *FACTORS)
    run.publish(
        "Check of simulators and filters against what is claimed of them",
        (
            SEEDS,
            f"simulators: 1 h at {RATE:g} Hz; three axes of each sensor with a defect, one of each without",
            found,
            alarmed,
            f"false alarms at the true cut-off: {share(alarm, run.asked.filters * ROWS)} records, nominal 5 %",
        ),
        section("Defects", ("defect", "seen in", "found", "cause named", "names"), defects)
        + section("Right records", ("simulator", "records", "false alarms", "share", "by quantity"), rights)
        + section("Filters that are rows", heads, known, filtered)
        + section("No filter", ("filter", "records", *(f"{c:g} Hz" for c in ABSENT)), none)
        + section("Filters of no row", heads, others, "Rounded to a fourth of the standard deviation."),
    )


if __name__ == "__main__":
    main()

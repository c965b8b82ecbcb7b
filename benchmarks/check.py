"""The defects of simulators that `check` finds, the causes that it names, and its false alarms.

Four simulators are written out as their sources have them: the files that configure them are the claims. The recursion
of a bias, b = phi b + s w, is that of a filter. Each of the defects is seeded into one of them, with other random
numbers in each record; a record holds 1 h. Right records are those of the simulators without a defect.
"""

from table import begin, section

import math
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

import allanite as al
from allanite.claims.checking import check
from allanite.claims.claim import claim_of

RATE, SIZE = 100.0, 360_000
Rng = np.random.Generator


@dataclass(frozen=True)
class Sensor:
    """What a configuration says of a sensor, and what its simulator does with it.

    `white` and `drive` draw numbers; `step` and `walk` are the exponents of the sample interval by which density and
    random walk are multiplied; `time` is the correlation time that is used.
    """

    density: float
    walk: float
    time: float = math.inf
    white: Callable[[Rng, int], np.ndarray] = lambda rng, n: rng.standard_normal(n)
    drive: Callable[[Rng, int], np.ndarray] = lambda rng, n: rng.standard_normal(n)
    sigma: Callable[["Sensor", float], float] = lambda s, dt: s.density / math.sqrt(dt)
    bias: Callable[["Sensor", float], float] = lambda s, dt: (
        s.walk * math.sqrt(dt) if math.isinf(s.time) else
        math.sqrt(-s.walk**2 * s.time / 2 * math.expm1(-2 * dt / s.time))
    )  # fmt: skip
    added: bool = True
    scale: float = 1.0

    def samples(self, rng: Rng) -> np.ndarray:
        """The output of one axis at rest."""
        dt = 1 / RATE
        rates = self.sigma(self, dt) * self.white(rng, SIZE)
        if self.added:
            phi = 1.0 if math.isinf(self.time) else math.exp(-dt / self.time)
            rates = rates + lfilter([self.bias(self, dt)], [1.0, -phi], self.drive(rng, SIZE))
        return self.scale * rates


@dataclass(frozen=True)
class Simulator:
    """A configuration as text, and its sensors."""

    name: str
    file: str
    gyro: Sensor
    accelerometer: Sensor

    def record(self, rng: Rng, axes: str) -> al.Recording:
        """A recording at rest of these axes: g for one of the gyro, a for one of the accelerometer."""
        sensors = {"g": (self.gyro, "rad/s"), "a": (self.accelerometer, "m/s^2")}
        made = ((*sensors[letter], f"{letter}{i}") for i, letter in enumerate(axes))
        return al.Recording(tuple(al.Record(s.samples(rng), RATE, unit, name=name) for s, unit, name in made))


def classic(gyro: Sensor, accelerometer: Sensor) -> str:
    """The IMU plugin of gazebo-classic, as RotorS and the SITL of PX4 have it."""
    fields = (("NoiseDensity", "density"), ("RandomWalk", "walk"), ("BiasCorrelationTime", "time"))
    lines = [
        f"  <{sensor}{field}>{getattr(of, key)!r}</{sensor}{field}>"
        for sensor, of in (("gyroscope", gyro), ("accelerometer", accelerometer))
        for field, key in fields
    ]
    return "\n".join(['<plugin name="imu_plugin" filename="libgazebo_imu_plugin.so">', *lines, "</plugin>"])


def gazebo(gyro: Sensor, accelerometer: Sensor) -> str:
    """The noise of gz-sensors: a standard deviation per sample."""
    parts = []
    for element, of in (("angular_velocity", gyro), ("linear_acceleration", accelerometer)):
        noise = (
            f'<noise type="gaussian"><mean>0</mean><stddev>{of.density * math.sqrt(RATE)!r}</stddev>'
            f"<dynamic_bias_stddev>{of.walk!r}</dynamic_bias_stddev>"
            f"<dynamic_bias_correlation_time>{of.time!r}</dynamic_bias_correlation_time></noise>"
        )
        parts.append(f"<{element}>" + "".join(f"<{axis}>{noise}</{axis}>" for axis in "xyz") + f"</{element}>")
    return "<imu>" + "".join(parts) + "</imu>"


def pegasus(gyro: Sensor, accelerometer: Sensor) -> str:
    """The IMU of Pegasus."""
    parts = (
        f'"{name}": {{"noise_density": {of.density!r}, "random_walk": {of.walk!r}, '
        f'"bias_correlation_time": {of.time!r}}}'
        for name, of in (("gyroscope", gyro), ("accelerometer", accelerometer))
    )
    return "{" + ", ".join(parts) + f', "update_rate": {RATE}}}'


def kalibr(gyro: Sensor, accelerometer: Sensor) -> str:
    """White noise and a random walk."""
    return "\n".join(
        f"{name}_noise_density: {of.density!r}\n{name}_random_walk: {of.walk!r}"
        for name, of in (("gyroscope", gyro), ("accelerometer", accelerometer))
    )


SITL = Sensor(1.8665e-4, 3.8785e-5, 1000.0), Sensor(1.86e-3, 6e-3, 300.0)
SHIPPED = Sensor(3.394e-4, 3.8785e-5, 1000.0), Sensor(4e-3, 6e-3, 300.0)
ADIS16448 = Sensor(1.6968e-4, 1.9393e-5), Sensor(2e-3, 3e-3)
SHORT = Sensor(3.394e-4, 3.8785e-5, 300.0), Sensor(4e-3, 6e-3, 30.0)

RIGHT = {
    row.name: row
    for row in (
        Simulator("kalibr", kalibr(*ADIS16448), *ADIS16448), Simulator("gazebo", gazebo(*SITL), *SITL),
        Simulator("pegasus", pegasus(*SHIPPED), *SHIPPED), Simulator("gazebo-classic", classic(*SITL), *SITL),
    )
}  # fmt: skip


@dataclass(frozen=True)
class Defect:
    """A defect: where it was seen, the simulator with it, and what the cause must say."""

    name: str
    seen: str
    simulator: Simulator
    cause: str


def wrong(name: str, *, both: bool = False, **changes: object) -> Simulator:
    """A simulator whose gyro, or both sensors, differ from its configuration."""
    right = RIGHT[name]
    accelerometer = replace(right.accelerometer, **changes) if both else right.accelerometer
    return replace(right, gyro=replace(right.gyro, **changes), accelerometer=accelerometer)


def uniform(rng: Rng, n: int) -> np.ndarray:
    """rand(): between 0 and 1."""
    return rng.random(n)


def timed(pair: tuple[Sensor, Sensor]) -> Simulator:
    """Pegasus with the correlation time of the accelerometer in the gyro."""
    gyro, accelerometer = pair
    return Simulator("pegasus", pegasus(*pair), replace(gyro, time=accelerometer.time), accelerometer)


def squared(gyro: Sensor, accelerometer: Sensor) -> Simulator:
    """Gazebo with white noise alone, whose variance is taken for its standard deviation."""
    wrong = (replace(sensor, sigma=lambda s, dt: s.density**2 / dt) for sensor in (gyro, accelerometer))
    return Simulator("gazebo", gazebo(gyro, accelerometer), *wrong)


DEFECTS = (
    Defect("correlation time of the accelerometer in the gyro, 300 s and 30 s", "PegasusSimulator#148", timed(SHORT),
           "correlation time of the other"),
    Defect("the same with the shipped times, 1000 s and 300 s", "PegasusSimulator#148", timed(SHIPPED),
           "correlation time of the other"),
    Defect("bias driven by rand()", "PegasusSimulator#148", wrong("pegasus", drive=uniform, both=True),
           "driven by rand()"),
    Defect("white noise by rand() - 0.5", "rand for randn",
           wrong("pegasus", white=lambda rng, n: rng.random(n) - 0.5, both=True), "rand() instead of randn()"),
    Defect("white noise by rand(): the mean is not zero", "rand for randn", wrong("kalibr", white=uniform, both=True),
           "mean is not zero"),
    Defect("bias never added", "PegasusSimulator#148", wrong("pegasus", added=False, both=True), "bias is not added"),
    Defect("density taken for the deviation of a sample", "PX4-gazebo-models#33",
           wrong("gazebo-classic", sigma=lambda s, dt: s.density, both=True), "value per sample"),
    Defect("white noise 300 times", "PX4-SITL_gazebo-classic#73",
           wrong("gazebo-classic", sigma=lambda s, dt: 300 * s.density / math.sqrt(dt)), "300"),
    Defect("white noise times sqrt(dt): depends on the rate", "rosflight_ros_pkgs#254",
           wrong("gazebo-classic", sigma=lambda s, dt: s.density * math.sqrt(dt), both=True), "depends on the rate"),
    Defect("degrees for radians", "units", wrong("kalibr", scale=180 / math.pi), "degrees and radians"),
    Defect("deviation squared: variance for deviation", "mir_robot#99",
           squared(Sensor(1.7e-5, 0.0), Sensor(1.7e-3, 0.0)), "is squared"),
    Defect("random walk per sample, without sqrt(dt)", "gnss-ins-sim#19",
           wrong("kalibr", bias=lambda s, dt: s.walk, both=True), "value per sample"),
    Defect("sqrt(h) read as sqrt(s)", "units", wrong("kalibr", sigma=lambda s, dt: 60 * s.density / math.sqrt(dt)),
           "sqrt(h) and"),
    Defect("deviation of the bias for its density", "gz-sensors#616",
           wrong("gazebo", bias=lambda s, dt: s.walk * math.sqrt(-math.expm1(-2 * dt / s.time)), both=True),
           "standard deviation of the bias"),
)  # fmt: skip


def checked(simulator: Simulator, rng: Rng, axes: str) -> "al.claims.ClaimCheck":
    """What is found of one record."""
    return check(simulator.record(rng, axes), claim(simulator))


def claim(simulator: Simulator) -> object:
    """What its file claims, recognized by its fields."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "noise.txt"
        path.write_text(simulator.file)
        return claim_of(path, rate=RATE)


def share(count: int, of: int) -> str:
    """A count of a number of records."""
    return f"{count} of {of}"


def defect_row(number: int, defect: Defect, records: int) -> tuple[list[str], bool, bool]:
    """A line of the table; whether the defect is found in all records, and its cause named in more than half."""
    found = named = names = 0
    for seed in range(records):
        seen = checked(defect.simulator, np.random.default_rng((1, number, seed)), "gggaaa")
        said = [sentence for cause in seen.causes for sentence in cause.sentences if sentence]
        found += not seen.agrees
        named += any(defect.cause in sentence for sentence in said)
        names += max((len(cause.names) for cause in seen.causes), default=0)
    print(defect.name, found, named, file=sys.stderr, flush=True)
    row = [defect.name, defect.seen, share(found, records), share(named, records), f"{names / records:.1f}"]
    return row, found == records, named > records / 2


def right_row(number: int, simulator: Simulator, records: int) -> tuple[list[str], int]:
    """A line of the table; the number of false alarms."""
    alarms, kinds = 0, []
    for seed in range(records):
        seen = checked(simulator, np.random.default_rng((2, number, seed)), "ga")
        alarms += not seen.agrees
        kinds += [row.quantity for row in seen.terms if row.contradicts]
    print(simulator.name, alarms, kinds, file=sys.stderr, flush=True)
    listed = ", ".join(f"{kind} {kinds.count(kind)}" for kind in dict.fromkeys(kinds))
    return [simulator.name, str(records), str(alarms), f"{100 * alarms / records:.1f} %", listed], alarms


def main() -> None:
    """Run what is asked for."""
    run = begin(__doc__, records=5, right=100)
    defects = [defect_row(i, defect, run.asked.records) for i, defect in enumerate(DEFECTS)]
    right = [right_row(i, one, run.asked.right) for i, one in enumerate(RIGHT.values())]
    alarms, total = sum(count for _, count in right), run.asked.right * len(right)
    run.publish(
        "Check of simulators against their configurations",
        (
            "seeds: (1, defect, record) and (2, simulator, record)",
            f"1 h at {RATE:g} Hz; three axes of each sensor with a defect, one of each without",
            f"found in every record: {share(sum(every for _, every, _ in defects), len(defects))} defects; cause named "
            f"in more than half of the records: {share(sum(most for _, _, most in defects), len(defects))}",
            f"false alarms: {share(alarms, total)} right records, {100 * alarms / total:.1f} %",
        ),
        section("Defects", ("defect", "seen in", "found", "cause named", "names"), [row for row, *_ in defects])
        + section(
            "Right records", ("simulator", "records", "false alarms", "share", "by quantity"), [r for r, _ in right]
        ),
    )


if __name__ == "__main__":
    main()

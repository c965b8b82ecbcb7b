"""Logs of strangers: units and clocks are read right, or asked for by a line that leads to them; and bags, in time.

Log k is drawn with the seed (seed, k) by a generator that knows nothing of the package. What `allanite info FILE`
prints is typed as it stands, with the truth in the place of UNIT and HZ, up to three commands. A file of ROS has the
units of its messages. Ends with exit code 1 below 97 % of right ones, or at one that is wrong.

Bags hold one topic of sensor_msgs/Imu at 200 Hz; each is read in a new process. Time is that of the processor, of the
process and of those that it starts, the less of two.
"""

from table import begin, least, section

import json
import os
import re
import shlex
import struct
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from click.testing import CliRunner
from tests import bag_files

import allanite as al
from allanite.cli import main as command
from allanite.core.units import unit_of

SHARE, COMMANDS, ENDS = 0.97, 3, ("right", "wrong", "unanswered")
GYRO = {"deg/s": (1.0, 4), "rad/s": (np.pi / 180, 6), "mdeg/s": (1e3, 2)}  # of a degree a second, and digits
ACCEL = {"g": (1.0, 5), "m/s^2": (9.80665, 4), "mg": (1e3, 2)}  # of 1 g, and digits

MAKES = {  # language, names of the clock, of gyros and accelerometers, and axes
    "ROS": ("en", ("t", "stamp"), "angular_velocity.{}", "linear_acceleration.{}", "xyz"),
    "short": ("en", ("t", "time", "Time"), "g{}", "a{}", "xyz"),
    "tracker": ("en", ("Time",), "Gyr_{}", "Acc_{}", "XYZ"),
    "phone": ("en", ("timestamp",), "rotationRate{}", "userAcceleration{}", "XYZ"),
    "numbers": ("en", ("time",), "gyro[{}]", "accel[{}]", "012"),
    "German": ("de", ("Zeit", "Zeitstempel"), "Drehrate {}", "Beschleunigung {}", "XYZ"),
    "French": ("fr", ("temps",), "vitesse angulaire {}", "accélération {}", "xyz"),
    "Spanish": ("es", ("tiempo",), "velocidad angular {}", "aceleración {}", "xyz"),
    "Italian": ("it", ("tempo",), "velocità angolare {}", "accelerazione {}", "XYZ"),
    "Russian": ("ru", ("Время", "время"), "Гироскоп {}", "Акселерометр {}", "XYZ"),
    "Chinese": ("zh", ("时间",), "陀螺仪{}", "加速度计{}", "XYZ"),
    "Japanese": ("ja", ("時間",), "角速度{}", "加速度{}", "XYZ"),
    "Korean": ("ko", ("시간",), "각속도 {}", "가속도 {}", "XYZ"),
}
COMMAS = ("de", "fr", "es", "it", "pt", "ru")
CLOCKS = (
    "none", "s", "ms", "us", "ns", "unix s", "unix ms", "unix us", "unix ns", "%Y-%m-%dT%H:%M:%S.%f",
    "%d.%m.%Y %H:%M:%S.%f", "%d.%m.%y %H:%M:%S.%f", "%m/%d/%y %H:%M:%S.%f", "%m/%d/%Y %H:%M:%S.%f", "%H:%M:%S.%f",
)  # fmt: skip
HEADINGS = ("none", "names", "brackets", "units below", "groups", "groups and units")
LAYOUTS = ("ag", "ga", "g", "a", "agt", "gat")
RATES = (10.0, 12.5, 25.0, 50.0, 100.0, 125.0, 200.0, 250.0, 400.0, 500.0, 1000.0, 2000.0)
SIZES = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}


@dataclass
class Log:
    """A file, what it is, its rate, the unit of each sensor, and the sensor of each column by its position."""

    text: str
    about: dict[str, str]
    rate: float
    units: dict[str, str]
    sensors: dict[int, str]


def stamps(rng, clock: str, rate: float, count: int) -> list[str]:
    """Time stamps as they are written."""
    i = np.arange(count)
    if clock.startswith("%"):
        day = datetime(2026, int(rng.integers(1, 13)), int(rng.integers(1, 29)), int(rng.choice([3, 17, 23])), 59, 58)
        return [(day + timedelta(seconds=float(k / rate))).strftime(clock) for k in i]
    unit, since = clock.rsplit(maxsplit=1)[-1], clock.startswith("unix")
    start = int(1.4e9 + rng.integers(10**8)) if since else float(rng.choice([0.0, 12.5, 9123.25]))
    if unit == "s":
        return [f"{start + k / rate:.6f}" for k in i]
    return [str(int(start * SIZES[unit]) + round(k * SIZES[unit] / rate)) for k in i]


def headed(columns: list[tuple[str, str, str]], heading: str, bracket: str, separator: str) -> list[str]:
    """The lines of a heading over columns of a group, a name and a unit."""
    line = separator.join
    whole = [group.format(axis) for group, axis, _ in columns]
    units = [unit for *_, unit in columns]
    bracketed = (name + bracket.format(unit) * bool(unit) for name, unit in zip(whole, units, strict=True))
    plain = {"none": [], "names": [whole], "brackets": [bracketed], "units below": [whole, units]}
    if heading in plain:
        return list(map(line, plain[heading]))
    stems = [group.format("").strip("_ .[]") + (bracket.format(unit) if unit and heading == "groups" else "")
             for group, _, unit in columns]  # fmt: skip
    merged = ["" if i and stem == stems[i - 1] else stem for i, stem in enumerate(stems)]
    return [line(merged), line(axis for _, axis, _ in columns), *[line(units)] * (heading != "groups")]


def written(values, size: float, digits: int) -> list[list[str]]:
    """The samples of each axis in a unit of this size."""
    return [[f"{value:.{digits}f}" for value in axis] for axis in (values * size).T]


def log(seed: int, number: int) -> Log:
    """The file that a seed draws."""
    rng = np.random.default_rng((seed, number))

    def pick(choices):
        return choices[int(rng.integers(len(choices)))]

    make, clock, heading, layout = (pick(choices) for choices in (list(MAKES), CLOCKS, HEADINGS, LAYOUTS))
    (language, times, of_gyro, of_accel, axes), unit = MAKES[make], clock.split()[-1]
    fits = [r for r in RATES if unit != "ms" or 1000 % r == 0]
    rate, count = pick(fits), int(rng.integers(600, 1500))
    heading = "names" if make in ("ROS", "numbers") and heading.startswith("groups") else heading
    units = {"gyro": pick(list(GYRO)), "accel": pick(list(ACCEL))}
    if make == "ROS" and heading == "names":  # which define them
        units = {"gyro": "rad/s", "accel": "m/s^2"}
    down = rng.standard_normal(3) if rng.random() < 0.3 else np.eye(3)[rng.integers(3)] * rng.choice([-1, 1])
    down *= (1 + rng.uniform(-0.03, 0.03)) / np.linalg.norm(down)
    noise, bias = rng.standard_normal((2, count, 3)), rng.uniform(-0.8, 0.8, 3)
    samples = {"a": written(down + 2e-3 * noise[0], *ACCEL[units["accel"]]),
               "g": written(bias + 0.08 * noise[1], *GYRO[units["gyro"]]),
               "t": [[f"{31.5 + 0.4 * k / count:.2f}" for k in range(count)]]}  # fmt: skip
    comma = language in COMMAS and rng.random() < 0.7
    separator = pick((";", "\t") if comma else (",", ";", "\t", ", "))
    columns, values = [], []
    if clock != "none":
        columns.append((pick(times), "", unit if unit in SIZES else ""))
        values.append(stamps(rng, clock, rate, count))
    of, sensors = {"g": ("gyro", of_gyro, axes), "a": ("accel", of_accel, axes), "t": ("", "temp", [""])}, {}
    for sensor, pattern, letters, own in ((*of[letter], samples[letter]) for letter in layout):
        values += own
        for axis in letters:
            columns.append((pattern, axis, units.get(sensor, "degC")))
            sensors |= {len(columns): sensor} if sensor else {}
    if comma:
        values = [c if clock[0] == "%" and not i else [v.replace(".", ",") for v in c] for i, c in enumerate(values)]
    rows = list(map(separator.join, zip(*values, strict=True)))
    if rng.random() < 0.1:
        rows[count // 2 : count // 2] = ["# paused", "# resumed"]
    lines = headed(columns, heading, pick((" ({})", " [{}]", "({})")), separator) + rows
    about = {"make": make, "heading": heading, "clock": clock}
    return Log("\n".join(lines) + "\n", about, rate, units, sensors)


def filled(line: str, log: Log) -> str:
    """A line to copy with the truth in the place of its placeholders."""
    every = ",".join(f"{place}={log.units[sensor]}" for place, sensor in log.sensors.items())
    known = log.units | {str(place): log.units[sensor] for place, sensor in log.sensors.items()}
    line = re.sub(r"\bHZ\b", f"{log.rate:g}", line)
    line = re.sub(r"\[UNIT\]", f"[{log.about['clock'].split()[-1]}]", line)
    line = re.sub(r"(gyro|accel|\d+)=UNIT", lambda match: f"{match[1]}={known.get(match[1], 'degC')}", line)
    stated = re.findall(r"(\d+)=", line)
    line = line.replace("COLUMN=UNIT", ",".join(part for part in every.split(",") if part.split("=")[0] not in stated))
    return re.sub(r"--unit '?UNIT'?", f"--unit {every}", line)


def answer(path: Path, log: Log) -> tuple[str, int]:
    """Whether the answer is right, wrong, or there is none, and after how many commands."""
    words = ["info", str(path), "--json", "-"]
    for number in range(1, COMMANDS + 1):
        done = CliRunner().invoke(command, words)
        if done.stdout.lstrip().startswith("{"):
            return judged(json.loads(done.stdout)["channels"], log), number
        tried = re.search(r"^try: allanite (.*)", done.stderr, re.MULTILINE)
        if not tried:
            break
        words = shlex.split(filled(tried[1], log))
    return "unanswered", number


def judged(channels: list, log: Log) -> str:
    """Whether the rate, the sensors and the scales are the truth."""
    sensors = [{"gyro": "gyro", "accelerometer": "accel"}.get(c["signal"], c["signal"]) for c in channels]
    fine = sensors == list(log.sensors.values()) and all(
        c["kind"] == "rate" and abs(c["rate"] / log.rate - 1) < 2e-3
        and abs(unit_of(c["unit"]).factor * (c["scale"] or 1) / unit_of(log.units[s]).factor - 1) < 1e-6
        for c, s in zip(channels, sensors, strict=True)
    )  # fmt: skip
    return "right" if fine else "wrong"


def strangers(seed: int, count: int) -> tuple[list[str], bool]:
    """The section of so many logs, and whether the demand is met."""
    of, failed = dict[tuple[str, str], Counter[str]](), []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            drawn, path = log(seed, number), Path(folder, f"log{number}.csv")
            path.write_text(drawn.text, encoding="utf-8")
            end, commands = answer(path, drawn)
            for which in (("all", ""), ("commands", str(commands)), *drawn.about.items()):
                of.setdefault(which, Counter())[end] += 1
            failed += [f"{number} ({end})"] if end != "right" else []
    ends = of["all", ""]
    met = ends["right"] >= SHARE * count and not ends["wrong"]
    rows = [(*which, *(str(own[end]) for end in ENDS)) for which, own in sorted(of.items())]
    about = f"Right at least {SHARE:.0%}, wrong none: {'met' if met else 'MISSED'}. Not right: {len(failed)}"
    return section("Logs", ("of", "which", *ENDS), rows, ", ".join((about, *failed))), met


# --- bags ------------------------------------------------------------------------------------------------------------

INTERVAL, START = 5_000_000, 1_700_000_000_000_000_000  # ns
FORMS = {
    "bag": ("bag", ""), "bag, lz4": ("bag", "lz4"), "bag, bz2": ("bag", "bz2"), "db3": ("db3", ""),
    "db3, zstd by message": ("db3", "message"), "db3, zstd of the file": ("db3", "file"), "mcap": ("mcap", ""),
    "mcap, zstd by chunk": ("mcap", "storage"),
}  # fmt: skip


def messages(form: str, count: int) -> Iterator[tuple[int, bytes]]:
    """Receive times and bytes of messages that differ in stamps and values."""
    values = np.random.default_rng(1).normal(size=(count, 6))
    data = bytearray(bag_files.packed(form, bag_files.imu(form, START, np.arange(1.0, 7.0))))
    places = [data.index(struct.pack("<d", k)) for k in (2.0, 5.0)]  # 1.0 is the orientation, too
    at = data.index(struct.pack("<I", START // 10**9))
    for k in range(count):
        stamp = START + k * INTERVAL
        struct.pack_into("<II", data, at, stamp // 10**9, stamp % 10**9)
        for place, row in zip(places, (values[k, :3], values[k, 3:]), strict=True):
            struct.pack_into("<3d", data, place - 8, *row)
        yield stamp + 1000, bytes(data)


def measured(path: Path) -> float:
    """Seconds in which a bag is read, by this process and those that it starts."""
    return least(partial(al.read, path), 2, lambda: sum(os.times()[:4]))


def bag(name: str, count: int) -> tuple[str, ...]:
    """The row of a form."""
    form, compression = FORMS[name]
    topic = bag_files.Topic("/imu/data", bag_files.IMU, messages(form, count))
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(1, get_context("spawn")) as own:
        path = bag_files.write(Path(folder), form, [topic], compression=compression)
        megabytes = bag_files.file_of(path).stat().st_size / 1e6
        return name, f"{megabytes:.0f}", f"{own.submit(measured, path).result():.1f}"


def main() -> int:
    run = begin(__doc__, seed=61, logs=300, messages=1_000_000, forms=list(FORMS))
    lines, met = strangers(run.asked.seed, run.asked.logs)
    rows = [bag(form, run.asked.messages) for form in run.asked.forms]
    notes = [f"seeds ({run.asked.seed}, number of the log); 1 of the {run.asked.messages} messages of each bag"]
    bags = section("Bags", ("bag", "MB", "allanite s"), rows)
    run.publish("Logs of strangers, and bags", notes, [*lines, *bags])
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())

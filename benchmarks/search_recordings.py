"""What the default analysis says of each channel of real recordings, by one code or another.

    ALLANITE_RECORDINGS=folder python benchmarks/search_recordings.py run [--also LIST.json] --out FILE.jsonl
    python benchmarks/search_recordings.py table OLD.jsonl [NEW.jsonl]

The interpreter chooses the code. The recordings are not part of the project; INDEX.md of the folder says where each
comes from. LIST.json names further files: objects with `file`, `choices` (fields of `Recipe`) and, where it is known,
`N`: the right value by a part of the channel's name, in deg/sqrt(h) or m/s/sqrt(h). N is compared with the measured
Allan deviation where its slope is -1/2, and with the median level of the octaves from 0.02 to 0.5 of the rate.
"""

from table import markdown

import argparse
import itertools
import json
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import allanite as al
from allanite.study.noise import noise_of
from search_cells import described, lines_of

IMU = {"unit": "gyro=deg/s,accel=g"}
SELECTING = ("start", "until")
"""Choices that are not those of a reader."""

RECORDINGS: tuple[tuple[str, dict[str, Any]], ...] = (
    *((f"adis_16405_imu{i}.rda", IMU) for i in (1, 2, 3)),
    ("mpu6050_static10min/mpu6050_gyroscope.mat", {"rate": 100.0, "unit": "deg/s"}),
    ("mpu6050_static10min/mpu6050_accelerometer.mat", {"rate": 100.0, "unit": "g"}),
    ("phone_gyro4.txt", {"unit": "rad/s"}),
    ("phone_acc2.txt", {"unit": "m/s^2"}),
    ("vn100_car_idle.bag", {}),
    ("xsens_mti_utbm_imu-test.bag", {}),
    ("ig500n_milkytipo.txt", {"rate": 4.16, "unit": "deg/s", "channels": ("7", "8", "9")}),
    ("ig500n_milkytipo.txt", {"rate": 4.16, "unit": "m/s^2", "channels": ("4", "5", "6")}),
    ("psins_lasergyro.imu", {}),
    ("aegiverse_fog_0917.txt", {"unit": "deg/h"}),
    ("aegiverse_fpga_gyro_0802.txt", {"rate": 96.0717, "unit": "deg/s", "channels": ("2", "3")}),
    ("cubeorange_sample_log_small.ulg", {}),
    ("imu_tk_xsens_gyro.mat", {"rate": 100.0, "unit": "deg/s", "until": 50.0}),
)
"""Public recordings of sensors at rest, with what their files do not say."""


@dataclass(frozen=True)
class Source:
    """A file, how it is read, and the right N of its channels."""

    path: Path
    choices: dict[str, Any]
    N: dict[str, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The file, and its channels where they are chosen."""
        return " ".join([self.path.name, *self.choices.get("channels", ())])


def sources(also: Path | None) -> Iterator[Source]:
    """The recordings of the folder, and those of a list."""
    folder = Path(os.environ["ALLANITE_RECORDINGS"])
    for name, choices in RECORDINGS:
        yield Source(folder / name, choices)
    for row in json.loads(also.read_text(encoding="utf-8")) if also else ():
        yield Source(Path(row["file"]), row["choices"], row.get("N", {}))


def spent() -> float:
    """Seconds of processor time, of finished children too."""
    return sum(os.times()[:4])


def deviations(y: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Overlapping Allan deviation at octaves of the averaging time, with a fiftieth of the record as the longest."""
    angle = np.concatenate([[0.0], np.cumsum(y)]) / rate
    m = 2 ** np.arange(max(int(math.log2(y.size / 50)) + 1, 2))
    second = [angle[2 * k :] - 2 * angle[k:-k] + angle[: -2 * k] for k in m]
    return m / rate, np.array([math.sqrt(np.mean(d**2) / 2) / (k / rate) for d, k in zip(second, m, strict=True)])


STRAIGHT = 0.08
"""How far the slope of an octave may be from -1/2."""


def read_off(y: np.ndarray, rate: float) -> float | None:
    """N where the slope of the deviation is -1/2, of the longest run of octaves; none if it is so at no octave."""
    tau, deviation = deviations(y, rate)
    straight = np.abs(np.diff(np.log2(deviation)) + 0.5) < STRAIGHT
    best, first = (0, 0), 0
    for i, good in enumerate([*straight, False]):
        if not good:
            best, first = max(best, (i - first, -first)), i + 1
    length, first = best[0], -best[1]
    if not length:
        return None
    inside = slice(first, first + length + 1)
    return float(np.exp(np.mean(np.log(deviation[inside] * np.sqrt(tau[inside])))))


def level(y: np.ndarray, rate: float) -> float:
    """N of the median power of five octaves, each taken from the median of its periodogram."""
    power = np.abs(np.fft.rfft(y)) ** 2 / y.size / rate
    f = np.arange(power.size) / y.size
    ends = [0.02, *(0.5 / 2**k for k in range(4, 0, -1)), 0.5]
    octaves = itertools.pairwise(ends)
    powers = [np.median(power[(f > low) & (f <= high)]) / math.log(2) for low, high in octaves]
    return math.sqrt(np.median(powers))


def right(source: Source, channel: str, unit: str) -> float | None:
    """The right N of a channel, SI."""
    for part, N in source.N.items():
        if part in channel:
            return (math.radians(N) if unit == "rad/s" else N) / 60
    return None


def channels(source: Source) -> Iterator[dict[str, Any]]:
    """A line for each channel of a file."""
    reading = {name: value for name, value in source.choices.items() if name not in SELECTING}
    recipe = al.Recipe(**{name: value for name, value in source.choices.items() if name in SELECTING})
    head = {"file": source.name}
    try:
        recording = al.read(source.path, **reading)
        begin = spent()
        study = al.analyze(recording, recipe)
    except al.AllaniteError as error:
        yield head | {"channel": "", "error": str(error)[:400]}
        return
    whole = spent() - begin
    for record, channel in zip(recording, study.channels, strict=True):
        first, last = (round((x or 0.0) * record.rate) for x in (recipe.start, recipe.until))
        y = record.rate_values[first : last or None]
        y = np.where(np.isnan(y), np.nanmean(y), y)
        line = head | {"channel": record.name, "n": y.size, "rate": record.rate, "cpu of file": whole}
        line |= {"read off": read_off(y - y.mean(), record.rate), "level": level(y - y.mean(), record.rate)}
        line |= {"right": right(source, record.name, record.signal.si[0]), "refusal": channel.refusal}
        line["warnings"] = [str(finding) for finding in channel.quality.warnings]
        if channel.noise is not None:
            line |= described(channel.noise) | {"verdict": channel.noise.verdict, "cpu": alone(record, recipe)}
        yield line


def alone(record: al.Record, recipe: al.Recipe) -> float | None:
    """Processor time of the identification of a whole channel, s."""
    begin = spent()
    try:
        noise_of(record, recipe)
    except al.AllaniteError:
        return None
    return spent() - begin


def run(also: Path | None, path: Path) -> None:
    """Append the files that are not yet in a file, each when it is whole."""
    done = {line["file"] for line in lines_of(path)}
    for source in sources(also):
        if source.name not in done:
            text = "".join(json.dumps(line) + "\n" for line in channels(source))
            with path.open("a", encoding="utf-8") as out:
                out.write(text)


HEADINGS = (
    "file", "channel", "side", "grade", "N", "N / read off", "N / level", "N / right", "B", "K", "GM", "filter",
    "CPU s", "said",
)  # fmt: skip
LONGEST = 150
"""Characters of what is said."""


def rows_of(sides: dict[str, list[dict[str, Any]]]) -> list[tuple[str, ...]]:
    """A row for each channel and side."""
    keys = dict.fromkeys((line["file"], line["channel"]) for lines in sides.values() for line in lines)
    known = {side: {(line["file"], line["channel"]): line for line in lines} for side, lines in sides.items()}
    return [(*key, side, *_row(known[side][key])) for key in keys for side in sides if key in known[side]]


def _row(line: dict[str, Any]) -> tuple[str, ...]:
    """What was said of a channel."""
    if "terms" not in line:
        why = line.get("error") or line["refusal"]
        return ("refused", *[""] * (len(HEADINGS) - 5), _short(why))
    terms, low_pass = line["terms"], line["filter"]
    ratios = [_ratio(terms["N"], line[key]) for key in ("read off", "level", "right")]
    markov = [
        f"{s} {terms[s]['status']}" for s in ("GM", "GML", "GM2") if s in terms and terms[s]["status"] != "absent"
    ]
    shown = f"{low_pass[0]} {low_pass[1]:.4g} Hz" if low_pass else ""
    statuses = [terms[symbol]["status"] if symbol in terms else "" for symbol in ("N", "B", "K")]
    cpu = "" if line["cpu"] is None else f"{line['cpu']:.1f}"
    said = "; ".join([*line["said"], *line["findings"]])
    return line["validity"], statuses[0], *ratios, *statuses[1:], ", ".join(markov), shown, cpu, _short(said)


def _ratio(term: dict[str, Any], to: float | None) -> str:
    """A coefficient and its limits, or the limit of one that is absent, over another."""
    if not to:
        return ""
    value, low, high, upper = (None if term[key] is None else f"{term[key] / to:.3f}" for key in
                               ("value", "low", "high", "upper"))  # fmt: skip
    if value is None:
        return f"< {upper}" if upper else ""
    return f"{value} ({low} .. {high})" if low or high else f"[{value}]"


def _short(text: str) -> str:
    """The begin of a sentence, without what a table has for itself."""
    return text[:LONGEST].replace("|", "/").replace("\n", " ")


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = parser.add_subparsers(dest="verb", required=True)
    asked = verbs.add_parser("run")
    asked.add_argument("--also", type=Path)
    asked.add_argument("--out", type=Path, required=True)
    verbs.add_parser("table").add_argument("files", type=Path, nargs="+")
    given = parser.parse_args()
    if given.verb == "run":
        run(given.also, given.out)
    else:
        print("\n".join(markdown(HEADINGS, rows_of({path.stem: list(lines_of(path)) for path in given.files}))))


if __name__ == "__main__":
    main()

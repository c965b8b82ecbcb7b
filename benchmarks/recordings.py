"""Public recordings: what the program says of each channel, beside what an expert reads off it.

    ALLANITE_RECORDINGS=folder python benchmarks/recordings.py [--write PATH]

The recordings are not part of the project; INDEX.md of the folder says where each comes from. The expert's figures are
computed here by numpy alone, from the samples as they are in the file:

- white level: the median of all periodogram ordinates (Hann window, pieces of a sixteenth of the record) in each third
  of an octave, over ln 2. The flat part has the most ordinates of all runs of bands of at least an octave whose levels
  are equal and do not slope (6 % of the density, beside chance); its level, that is N before a low-pass filter, is the
  mean by weight. Its error (2 sigma) is of chance, of scatter beyond it, and of what such a slope leaves open, 3 %.
- Allan deviation, overlapping, whose value at 1 s is N where white noise alone is there.

A claimed N is wrong if its 95 % interval and the expert's have no point in common, an upper limit if it lies below the
expert's interval; any claimed term is wrong if its own Allan deviation, with the lower limit of its coefficient,
exceeds the upper limit (3 standard errors) of the measured one somewhere. What is neither wrong nor confirmed, as there
is no flat part, is called open; refused is an answer that claims no N.
"""

from table import Row, begin, section

import math
import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, combinations
from multiprocessing import Pool
from pathlib import Path
from typing import Any

import numpy as np

import allanite as al
from allanite.comparison.sheet import SheetComparison
from allanite.reporting.digits import digits, printed_unit
from allanite.study.results import Channel

ADIS: dict[str, Any] = {"unit": "gyro=deg/s,accel=g"}
MPU: dict[str, Any] = {"time": "1"}
RECORDINGS: tuple[tuple[str, dict[str, Any], str], ...] = (
    *((f"adis_16405_imu{i}.rda", ADIS, "adis16405") for i in (1, 2, 3)),
    ("psins_lasergyro.imu", {}, ""),
    ("mpu6050_static10min/mpu6050_gyroscope.mat", MPU | {"unit": "deg/s"}, "mpu6050"),
    ("mpu6050_static10min/mpu6050_accelerometer.mat", MPU | {"unit": "g"}, "mpu6050"),
    ("phone_gyro4.txt", {"unit": "rad/s"}, ""), ("phone_acc2.txt", {"unit": "m/s^2"}, ""),
    ("ig500n_milkytipo.txt", {"rate": 4.16, "unit": "m/s^2", "channels": ("4", "5", "6")}, ""),
    ("ig500n_milkytipo.txt", {"rate": 4.16, "unit": "deg/s", "channels": ("7", "8", "9")}, ""),
    ("vn100_car_idle.bag", {}, ""), ("xsens_mti_utbm_imu-test.bag", {}, ""),
    ("cubeorange_sample_log_small.ulg", {}, ""),
    ("imu_tk_xsens_gyro.mat", {"rate": 100.0, "scale": "1deg/s", "until": 52.0, "channels": ("2", "3", "4")}, ""),
    ("aegiverse_fog_0917.txt", {"unit": "deg/h"}, ""),
    ("aegiverse_fpga_gyro_0802.txt", {"time": "1", "unit": "deg/s", "channels": ("2",)}, ""),
)  # fmt: skip
"""File, what it does not say (a unit that nobody states is assumed), and the data sheet of its sensor."""

PIECES, BANDS = 16, 3  # pieces of a periodogram, at least; bands an octave
FEWEST = 40  # ordinates of a band
HANN = 1.5  # neighbouring ordinates of a Hann window for one independent ordinate
FLAT = 0.06  # relative difference and change of the density in a flat part, beside 2 and 1 standard errors
TOP = 0.2  # relative change of the density over the last octave that is called falling or rising, beside 3 sigma
TERMS = {"N": (1.0, -0.5), "B": (math.sqrt(2 * math.log(2) / math.pi), 0.0), "K": (1 / math.sqrt(3), 0.5)}
"""Allan deviation of a term of size 1 at 1 s, and the power of the averaging time (IEEE Std 952)."""

EARLIEST, SHORT = 100, 30  # samples below which a filter changes the deviation of a term; at most this part of a record
UNITS = {"gyro": (math.degrees(1.0) * 60, "deg/√h"), "accelerometer": (60.0, "m/s/√h")}
"""Of a walk by sensor: how many make one of SI, and its name."""


@dataclass(frozen=True)
class Expert:
    """What the samples of a channel show without any model, in SI."""

    values: np.ndarray
    rate: float

    @cached_property
    def periodogram(self) -> tuple[np.ndarray, np.ndarray]:
        """Frequencies, Hz, and two-sided densities of the pieces that follow each other, shape (pieces, f)."""
        size = 2 ** int(math.log2(self.values.size // PIECES))
        window = np.hanning(size)
        pieces = self.values[: self.values.size // size * size].reshape(-1, size)
        pieces = (pieces - pieces.mean(axis=1, keepdims=True)) * window
        density = np.abs(np.fft.rfft(pieces)) ** 2 / (self.rate * np.sum(window**2))
        return np.arange(3, size // 2) * self.rate / size, density[:, 3 : size // 2]

    @cached_property
    def bands(self) -> tuple[np.ndarray, np.ndarray]:
        """Logarithms of the levels and their standard errors; the highest band first."""
        f, density = self.periodogram
        levels, errors = [], []
        for k in range(int(BANDS * math.log2(self.rate / 2 / f[0]))):
            end = self.rate / 2 * 2.0 ** (-k / BANDS)
            some = density[:, (f <= end) & (f > end * 2.0 ** (-1 / BANDS))]
            if some.size >= FEWEST:
                levels.append(math.log(float(np.median(some)) / math.log(2)))
                errors.append(math.sqrt(HANN / some.size) / math.log(2))
        return np.array(levels), np.array(errors)

    @cached_property
    def white(self) -> tuple[float, float] | None:
        """N, and its relative error (2 sigma)."""
        levels, errors = self.bands
        best = None
        for first, stop in combinations(range(levels.size + 1), 2):
            weight = errors[first:stop] ** -2
            if stop - first < BANDS or (best and weight.sum() <= best[0]):
                continue
            level = np.average(levels[first:stop], weights=weight)
            off, place = levels[first:stop] - level, np.arange(stop - first)
            at = place - np.average(place, weights=weight)
            spread = weight @ at**2
            change = (stop - first - 1) * abs(weight @ (at * off)) / spread
            if change < FLAT + (stop - first - 1) / math.sqrt(spread) and np.all(np.abs(off) < FLAT + 2 * weight**-0.5):
                scatter = 1 + max(weight @ off**2 - (stop - first - 1), 0.0)
                best = weight.sum(), level, scatter
        if best is None:
            return None
        total, level, scatter = best
        return math.exp(level / 2), math.hypot(math.sqrt(scatter / total), FLAT / 2)

    @cached_property
    def top(self) -> str:
        """What the density does over the last octave."""
        levels, errors = self.bands
        if levels.size <= BANDS:
            return ""
        ratio, error = math.exp(levels[0] - levels[BANDS]), math.hypot(errors[0], errors[BANDS])
        change = TOP + 3 * error
        if abs(math.log(ratio)) > change:
            return f"{'falls' if ratio < 1 else 'rises'}, × {ratio:.2f}"
        return f"{'flat' if abs(ratio - 1) < TOP else 'unclear'}, × {ratio:.2f}"

    def deviation(self, m: int) -> float:
        """Overlapping Allan deviation at an averaging factor."""
        x = np.concatenate(([0.0], np.cumsum(self.values - self.values.mean())))
        second = x[2 * m :] - 2 * x[m:-m] + x[: -2 * m]
        return math.sqrt(float(np.mean(second**2)) / 2) / m

    @cached_property
    def limits(self) -> list[tuple[float, float]]:
        """Averaging times, s, and upper limits of the deviation (Wilson and Hilferty's chi-square)."""
        points, m = [], min(EARLIEST, self.values.size // SHORT)
        while 4 * m <= self.values.size:
            degrees = self.values.size / m - 1
            chi = (1 - 2 / (9 * degrees) - 3 * math.sqrt(2 / (9 * degrees))) ** 3
            if chi > 0:
                points.append((m / self.rate, self.deviation(m) / math.sqrt(chi)))
            m *= 2
        return points

    def above(self, symbol: str, low: float) -> float | None:
        """The first averaging time, s, at which a term of at least this size exceeds the measured deviation."""
        size, power = TERMS[symbol]
        return next((tau for tau, limit in self.limits if low * size * tau**power > limit), None)


def expert_of(record: al.Record) -> Expert:
    """The longest run without missing samples."""
    y = np.asarray(record.values, dtype=np.float64) * record.factor
    y *= {"rate": 1.0, "increment": record.rate, "count": record.rate}[record.kind]
    inside = np.concatenate(([False], np.isfinite(y), [False]))
    start, stop = max(np.flatnonzero(np.diff(inside)).reshape(-1, 2).tolist(), key=lambda ends: ends[1] - ends[0])
    return Expert(y[start:stop], record.rate)


def verdict(channel: Channel, expert: Expert) -> tuple[str, str]:
    """Right, refused, open or wrong, and why it is wrong."""
    if channel.fit is None:
        return "refused", ""
    for e in channel.fit:
        if e.claimed and e.symbol in TERMS:
            tau = expert.above(e.symbol, e.interval(0.95)[0])
            if tau is not None:
                return "wrong", f"{e.symbol} is above the curve at {tau:.3g} s"
    N, white = channel.fit["N"], expert.white
    if white is None:
        return ("open" if N.claimed else "refused"), ""
    low, high = N.interval(0.95)
    below, above = white[0] * (1 - white[1]), white[0] * (1 + white[1])
    if N.claimed and low > above:
        return "wrong", "N is above the white level"
    if high < below:
        return "wrong", "N is below the white level"
    return ("right" if N.claimed else "refused"), ""


def row_of(name: str, sheet: str, channel: Channel) -> Row:
    """The row of a channel."""
    expert, signal = expert_of(channel.record), channel.record.signal.name
    factor, unit = UNITS[signal]
    judged, why = verdict(channel, expert)
    m = max(1, round(expert.rate))
    second = expert.deviation(m) * math.sqrt(m / expert.rate)
    grade, read, N, ratio = "refused", channel.refusal, "", ""
    if channel.noise is not None:
        estimate = channel.noise.fit["N"]
        low, high = (factor * x for x in estimate.interval(0.95))
        grade, scope = channel.noise.validity, channel.noise.fit.scope
        read = "; ".join(scope.sentences) if scope else ""
        N = f"{factor * estimate.value:.4g} ({low:.4g} .. {high:.4g})" if estimate.claimed else f"below {high:.3g}"
        N = N if math.isfinite(high) else estimate.status
        ratio = f"{estimate.value / second:.3f}" if estimate.claimed else ""
    white = expert.white
    level = f"{factor * white[0]:.4g} ± {factor * white[0] * white[1]:.2g}" if white else "no flat part"
    stated = al.planning.data_sheet_named(sheet).model(signal) if sheet else None
    printed = f"{factor * stated['N'].value:.3g}" if stated else ""
    shown = (grade, N, level, f"{factor * second:.4g}", ratio, expert.top, printed)
    return (name, channel.record.name, unit, *shown, f"{judged}: {why}" if why else judged, read)


HEADINGS = (
    "file", "channel", "unit", "grade", "N (95 %)", "white level", "deviation at 1 s",
    "N over deviation at 1 s", "last octave", "data sheet", "verdict", "read",
)  # fmt: skip


def beside(name: str, study: al.Study, sheet: al.planning.DataSheet) -> Iterator[Row]:
    """Every line of a data sheet beside what was measured, a row for each channel."""
    every = SheetComparison(study.channels, study.recipe, study.findings, study.notes, study.provenance, sheet)
    for channel in every:
        for m in every.measured(channel):
            size, limits = digits(m.value, m.low, m.high).plain()
            ratio, _ = digits(*m.ratio).plain()
            shown = (f"{m.claim.value:g}", size, limits, ratio, str(m.remark))
            yield name, channel.record.name, m.claim.printed, printed_unit(m.claim.unit), *shown


BESIDE = ("file", "channel", "quantity", "unit", "data sheet", "measured", "95 % interval", "ratio", "remark")


def rows_of(name: str, choices: dict[str, Any], sheet: str) -> tuple[list[Row], list[Row]]:
    """The rows of a file in both tables."""
    study = al.analyze(Path(os.environ["ALLANITE_RECORDINGS"]) / name, al.Recipe(**choices))
    rows = [row_of(name, sheet, channel) for channel in study.channels]
    return rows, list(beside(name, study, al.planning.data_sheet_named(sheet))) if sheet else []


def main() -> None:
    """Make the table."""
    run = begin(__doc__ or "", processes=2)
    with Pool(run.asked.processes) as pool:
        parts = pool.starmap(rows_of, RECORDINGS, chunksize=1)
    rows, printed = (list(chain.from_iterable(part)) for part in zip(*parts, strict=True))
    verdicts, grades = (Counter(row[i].partition(":")[0] for row in rows) for i in (10, 3))
    notes = [
        "no random numbers",
        f"{len(rows)} channels; " + ", ".join(f"{w}: {verdicts[w]}" for w in ("wrong", "open", "refused", "right")),
        ", ".join(f"{grade}: {n}" for grade, n in grades.items()),
        "last octave: density of its last third over that of the third an octave below",
    ]
    sheets = (al.planning.data_sheet_named(sheet) for sheet in sorted({row[2] for row in RECORDINGS} - {""}))
    about = "; ".join(f"{sheet.maker} {sheet.document}" for sheet in sheets)
    body = section("Channels", HEADINGS, rows) + section("Data sheets", BESIDE, printed, f"{about}.")
    run.publish("The first answer on real recordings, beside an expert's", notes, body)


if __name__ == "__main__":
    main()

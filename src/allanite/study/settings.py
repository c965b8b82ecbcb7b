"""Choices of jobs beside the recipe, without what the jobs need: the help of the command line reads these rows."""

import math
from dataclasses import dataclass
from typing import Any, Literal

from allanite.core.choices import DURATION, DURATIONS, GRID, INSTANT, LINES, PERCENT, SHARE, SPAN, Choices, choice
from allanite.core.ranges import PART, RATE, SAMPLES, SEED, SIZE, TIME, Range

# fmt: off

NW = Range(1, 50)
"""Time-half-bandwidth products of tapers."""
TOLERANCES = Range(0, 1, below=True)
UNAIDED, CALIBRATED = Range(1e-9, 1e7, "s"), Range(0, 1e7, "s")
"""Times without aid, and of calibration, that are computed with: so many Schuler periods have nodes."""


def grid(default: str) -> Any:
    """Averaging times."""
    return choice("GRID", "octave, decade, log, all, or seconds, e.g. 1,10,100.", kind=GRID, default=default, told="",
                  group="curve")


def _factors() -> Any:
    return choice("A,B,...", "Averaging factors, instead of --taus.")


def _unit() -> Any:
    return choice("UNIT", "Unit of the result.", told="deg/h, ug", flags=("--output-unit",), old=("--to",))


def _unexplained() -> Any:
    return choice("", "Use the coefficients of channels that no model explains, too.", default=False)


def _from_curve() -> Any:
    return choice(
        "", "Where no model explains the record, upper bounds read off the Allan deviation.", default=False)


@dataclass(frozen=True, repr=False)
class DeviationChoices(Choices):
    """The choices of `Deviations`."""

    statistic: tuple[str, ...] = choice("A,B,...", "Statistics.", default=("oadev",))
    taus: str | tuple[float, ...] = grid("octave")
    m: tuple[int, ...] | None = _factors()
    intervals: bool = choice("", "Confidence intervals; without them no noise is identified.", default=True,
                             flags=("--intervals/--no-intervals",))
    bias: Literal["exact", "published", "model", "plain"] | None = choice(
        "WORD",
        "Correct the bias: exact or published (theo1, totdev, mtotdev, ...), model (theobr, theoh); plain: none.",
        told="model for theobr and theoh if the noise is identified, else plain", parts=("plain",))
    join: float = choice(
        "SHARE", "Share of the record up to which theoh is the overlapping Allan deviation.", default=0.2, within=PART)
    divisor: int = choice(
        "N", "Divisor of the length for the number of bias ratios of theobr and theoh; 6 as in Stable32.", default=30,
        within=SAMPLES)
    edf: Literal["exact", "published"] = choice("WORD", "Degrees of freedom of the intervals: exact, or published, for "
                                                "the power law found at each time.", default="exact", parts=("exact",))
    power_law: bool = choice("", "Show the exponent of the power law of the noise at each averaging time; a ramp is "
                             "taken out first.", default=False, parts=(False,))
    threads: int = 1
    to: str | None = _unit()


@dataclass(frozen=True, repr=False)
class DensityChoices(Choices):
    """The choices of `Densities`."""

    estimator: str = choice("NAME", "Estimator: welch or multitaper.", default="welch")
    sides: str = choice("NAME", "One- or two-sided power spectral density.", default="one")
    bins: int | None = choice("", "Values per decade; 0 keeps all frequencies.", default=20, within=Range(0, 1e6))
    segment: float | None = choice("TIME", "Length of Welch's segments.", kind=INSTANT, told="an eighth of the record",
                                   within=TIME, synonyms=("nperseg", "nfft"), unlike=("nperseg", "nfft"))
    window: str | None = choice("NAME", "Window of the Welch estimator.", told="hann")
    bandwidth: float | None = choice("NW", "Time-half-bandwidth product NW of the tapers.", told="4", within=NW)
    tapers: int | None = choice("K", "Number of tapers.", told="2 NW - 3", within=Range(1, 2 * NW.high))
    weights: str | None = choice("NAME", "Weights of the tapers: eigen or equal.", told="eigen")
    fit: bool = choice("", "Identify the noise and draw its terms in the figure.", default=False)
    deviation: str | None = choice("NAME", "Integrate the density to this deviation: oadev, mdev, ohdev ...")
    to: str | None = _unit()


@dataclass(frozen=True, repr=False)
class WindowChoices(Choices):
    """The choices of `Windows`."""

    statistic: str = choice("NAME", "Statistic.", default="oadev")
    window: float | None = choice("TIME", "Length of a window.", kind=INSTANT, within=TIME,
                                  told="a tenth of the record")
    step: float | None = choice("TIME", "Distance between windows.", kind=INSTANT, within=TIME,
                                told="an eighth of a window")
    taus: str | tuple[float, ...] = grid("octave")
    m: tuple[int, ...] | None = _factors()
    to: str | None = _unit()


@dataclass(frozen=True, repr=False)
class NoiseChoices(Choices):
    """The choices of `NoiseSettings`."""

    model: str | None = choice("TERMS", "Noise model, e.g. 'N 0.01 deg/sqrt(h), GM 0.1 deg/h 20 s'.")
    sensor: str | None = choice(
        "NAME", "Or a typical gyro: mems, fog or rlg; or a ring laser that counts: gl1 or gl1-smooth.")
    datasheet: str | None = choice(
        "NAME", "Or the noise of a data sheet: adis16470 is its gyro, 'adis16470 accelerometer' the other sensor.")
    unexplained: bool = _unexplained()


@dataclass(frozen=True, repr=False)
class LengthChoices(Choices):
    """The length of a record, given by one of the two."""

    duration: float | None = choice("TIME", "Length: 3600, '10 min', 24h.", kind=DURATION)
    samples: int | None = choice("N", "Number of samples.", within=SAMPLES)


@dataclass(frozen=True, repr=False)
class PlanChoices(Choices):
    """The choices of `PlanSettings`, which has the usual durations."""

    durations: tuple[float, ...] = choice(
        "A,B,...", "Record lengths.", kind=DURATIONS, default=(), told="10 min,1 h,6 h,24 h")
    accuracy: float = choice("PERCENT", "Relative standard error of a coefficient to reach.", kind=PERCENT, default=0.1,
                             told="10; of a live stream 20", within=PART)
    ramp: bool | None = choice(
        "", "Assume a rate ramp of unknown size.", told="if the model has one", flags=("--ramp/--no-ramp",))


@dataclass(frozen=True, repr=False)
class CheckChoices(LengthChoices):
    """The choices of `SelfCheckSettings`."""

    records: int = choice("N", "Number of records to simulate.", default=100, within=Range(1, 1e6))
    seed: int = choice("N", "Seed of the random number generator.", default=1, within=SEED)
    max_bias: float | None = choice("PERCENT", "Limit on the bias of the coefficients.", kind=PERCENT, within=SIZE)
    min_coverage: float | None = choice("PERCENT", "Limit on the coverage of the intervals.", kind=PERCENT)
    max_false: float | None = choice(
        "PERCENT", "Limit on the records in which absent terms are reported.", kind=PERCENT)
    max_missed: float | None = choice("PERCENT", "Limit on the records in which terms are missed.", kind=PERCENT)


@dataclass(frozen=True, repr=False)
class StateSpaceChoices(Choices):
    """The choices of `StateSpaceSettings`."""

    tau: tuple[float, ...] = choice(
        "LO,HI", "Averaging times between which flicker is matched.", kind=DURATIONS, default=(1.0, 1000.0))
    ripple: float = choice("PERCENT", "Largest deviation from flicker.", kind=PERCENT, default=0.02, within=PART)
    order: int | None = choice("N", "Or the number of Gauss-Markov processes for flicker.", within=Range(1, 100))
    turn_on: str | None = choice("RATE", "Standard deviation of the turn-on bias, e.g. '3 deg/h'.")
    measurement: str = choice("NAME", "Measurement: auto, mean (exact) or sample.", default="auto")


@dataclass(frozen=True, repr=False)
class ComparisonChoices(Choices):
    """The choices of `ComparisonSettings`."""

    against: tuple[str, ...] | None = choice("A,B,...", "Channels of the second file to compare with --channels.")
    part: float | None = choice("TIME", "Compare the first part of a file, of this length, with the rest.",
        kind=INSTANT, within=TIME)
    datasheet: str | None = choice("NAME", "Compare a file with a data sheet, e.g. adis16470.")
    pool: bool = choice("", "Coefficients that two files have in common, as for three or more.", default=False)


@dataclass(frozen=True, repr=False)
class ClaimChoices(Choices):
    """What is claimed of the noise of a recording, and of the settings of its sensor."""

    claims: str | None = choice(
        "CLAIM", "File of a filter or simulator, limits file (.toml), name of a data sheet, or model: "
        "'N 0.3 deg/sqrt(h), K 3 deg/h/sqrt(h)'; settings behind it or alone: 'lowpass 42 Hz, rate 100 Hz'.")
    claims_from: str | None = choice("TARGET", "Program whose file it is.", told="recognized by its fields")
    at_most: bool = choice("", "The values are upper bounds, as those of data sheets and limits files.", default=False)
    tolerance: float = choice("PERCENT", "Difference that is accepted.", kind=PERCENT, default=0.02,
                              within=TOLERANCES)


@dataclass(frozen=True, repr=False)
class WatchChoices(Choices):
    """The choices of `WatchSettings`."""

    every: float | None = choice("TIME", "Time between reports.", kind=DURATION, told="10 s; of watch 5 % of the "
                                 "record, 10 s to 1 h", flags=("--refresh",))
    duration: float = choice(
        "TIME", "Stop after this time.", kind=DURATION, default=math.inf, told="never", flags=("--for",))
    idle: float = choice("TIME", "Stop after this time without data.", kind=DURATION, default=math.inf, told="never")
    baud: int = choice("N", "Baud rate of a serial port.", default=115200, within=Range(1, 1e9))
    accuracy: float = choice("PERCENT", "Relative standard error of a coefficient to reach.", kind=PERCENT, default=0.2,
                             told="10; of a live stream 20", within=PART)


@dataclass(frozen=True, repr=False)
class ExportChoices(Choices):
    """The choices of an export."""

    axis: str = choice("WORD", "Whose coefficients: worst, median, x, y, z, or each if the target takes one for each "
                       "axis.", default="worst")
    inflate: float = choice(
        "FACTOR", "Factor on all coefficients; it is written into the file.", default=1.0, told="1.0",
        within=Range(1e-6, 1e6))
    rate: float | None = None
    filter_rate: float | None = choice(
        "HZ", "Rate of the filter's steps.", told="the target's own, or the sampling rate", within=RATE)
    unexplained: bool = _unexplained()
    cover: bool | tuple[float, float] | None = choice(
        "[SPAN]", "Cover the noise and its upper limits between two averaging times, e.g. 1,1000, or from 1 s to a "
        "tenth of the record; --cover=no: do not.", kind=SPAN, told="where a filter would be over-confident")
    from_curve: bool = _from_curve()


@dataclass(frozen=True, repr=False)
class DriftChoices(Choices):
    """The choices of `DriftSettings`."""

    times: tuple[float, ...] = choice("A,B,...", "Times without aid.", kind=DURATIONS,
                                      default=(1.0, 10.0, 60.0, 600.0, 3600.0), told="1 s,10 s,1 min,10 min,1 h",
                                      within=UNAIDED)
    calibration: float | None = choice("TIME", "Time at rest before, over which the bias was averaged; 0: it was not.",
                                       kind=INSTANT, told="60 s; 0 with --turn-on", within=CALIBRATED)
    turn_on: tuple[str, ...] = choice("BIAS", "Standard deviation of a constant bias: '10 deg/h', '2 mg'; repeatable.",
                                      kind=LINES, default=(), told="", synonyms=("bias",))
    scale_factor: float = choice("SHARE", "Error of the scale factor, 1 sigma: 0.1%, 1000ppm or 0.001.", kind=SHARE,
                                 default=0.0, told="none",
                                 within=Range(0, 0.1, below=True), flags=("--scale-error",), old=("--scale-factor",))
    maneuver: tuple[str, ...] = choice(
        "SIZE", "On which the scale factor acts: '90 deg', '5 deg/s', '20 m/s', '2 m/s^2'; repeatable.",
        kind=LINES, default=(), told="", synonyms=("turn", "acceleration"))
    platform: Literal["strapdown", "level"] = choice("WORD", "strapdown: gravity acts through the tilt from the gyros; "
                                                     "level: the platform is kept level.", default="strapdown")
    schuler: bool = choice("", "The earth is round: what is kept level swings with 84.4 min.", default=False)
    require: tuple[str, ...] = choice(
        "LIMIT", "Largest drift, 1 sigma: '1 deg in 10 min', '100 m in 1 min'; repeatable. Exit code 4 if exceeded.",
        kind=LINES, default=(), told="", synonyms=("limit", "goal"))
    unexplained: bool = _unexplained()
    from_curve: bool = _from_curve()

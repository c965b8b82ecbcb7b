"""Choices of the applications, without what the applications need: the help of the command line reads these rows."""

from dataclasses import dataclass
from typing import Any

from allanite.extending import (  # isort: skip
    ANGLE, DURATION, INSTANT, LATITUDE, MODEL, POSITIVE, SAMPLES, TIME, Choices, Range, choice, separated)  # fmt: skip

SECONDS = separated(float, "seconds", example="60,300", within=TIME)

# fmt: off


@dataclass(frozen=True, repr=False)
class VerticalChoices(Choices):
    """The choices of `VerticalSettings`."""

    method: str = "complementary"
    time_constant: float | None = choice(
        "TIME", "Time constant of the filter.", kind=DURATION, told="the best for the noise")
    bias_time: float | None = choice(
        "TIME", "Time of the bias estimate, 1 / sqrt(k2), of a filter that has one.", kind=DURATION)
    gyro: str | None = choice("TERMS", "Noise of a gyro, e.g. 'N 0.3 deg/sqrt(h), B 10 deg/h'.", told="identified")
    accelerometer: str | None = choice(
        "TERMS", "Noise of an accelerometer, e.g. 'N 100 ug/sqrt(Hz), B 50 ug'.", told="identified")
    gate: float | None = choice(
        "DEG", "Ignore the accelerometers where their tilt differs from the angle by more than this.",
        within=Range(0, 180, "deg", above=True))
    keep_bias: bool = choice("", "Do not subtract the mean rates of a static recording.", default=False)
    axes: str | None = choice(
        "AXES", "Axes of the file that are forward, sideways and vertical, right-handed, e.g. y,-x,z.", told="x,y,z")


@dataclass(frozen=True, repr=False)
class FitChoices(Choices):
    """The choices of `FitSettings`."""

    terms: str = "auto"
    smooth: float = choice("S", "Smoothing window of --derivative-of.", default=60.0, told="60.0", within=TIME)
    blocks: int = choice("", "Number of blocks for cross-validation.", default=5, within=Range(3, 50))
    every: bool = choice("", "Keep all powers; skip cross-validation.", default=False)
    split_gaps: bool = choice("", "Treat each stretch between gaps separately.", default=False)
    least: float = choice("", "Effective samples required per regressor.", default=10.0, told="10.0", within=POSITIVE)


@dataclass(frozen=True, repr=False)
class CompensationChoices(Choices):
    """The choices of `CompensationSettings`."""

    regressors: tuple[str, ...] = choice("A,B,...", "Columns on which the rate may depend.", default=(), told="")
    degree: int = choice("", "Highest power of a regressor to try.", default=1, within=Range(1, 6))
    lags: tuple[float, ...] = choice("S,S,...", "Lags of the regressors, seconds.", kind=SECONDS, default=(), told="")
    derivative_of: tuple[str, ...] = choice("A,B,...", "Columns whose derivative is a regressor.", default=(), told="")
    trend: bool = choice("", "Estimate a linear drift beside the regressors; it is not removed.", default=True,
                         told="trend", flags=("--trend/--no-trend",))
    beside: str | None = choice("FILE", "Read the regressors from this file, with units and times.")
    interpolate: bool = choice(
        "", "Interpolate regressors of another time base to the record's samples.", default=False)
    use: str | None = choice("FILE", "Apply the regressions that --save wrote; no fit.")


@dataclass(frozen=True, repr=False)
class IntervalChoices(Choices):
    """The choices of `ExperimentSettings`."""

    interval: float = choice("TIME", "Measuring time.", kind=INSTANT, default=120.0, within=TIME)
    methods: tuple[str, ...] = choice("A,B,...", "Estimators, e.g. mean,optimal.", default=(), told="all")
    target: str = choice("WHAT", "What is estimated of a drifting rate: its mean, centre or start.", default="mean")
    dither: tuple[float, ...] = choice("HZ,...", "Frequencies of the residual dither to remove.", default=(), told="",
                                       within=Range(1e-9, 1e15, "Hz"))
    most: int | None = choice("N", "Maximum number of intervals to measure.", within=SAMPLES)


@dataclass(frozen=True, repr=False)
class EstimatorChoices(Choices):
    """The choices of `EstimatorSettings`."""

    window: str = choice("NAME", "Window of the hamming estimator.", default="hamming")
    lines: int | None = choice("N", "Number of regression lines of the conditional estimator.", within=SAMPLES)
    quantum: float | None = choice("", "Quantization step of the angle in --unit, if the samples are not counts.",
                                   within=POSITIVE)
    certified: bool = choice("", "Search the staircase for the proven optimum.", default=False)
    descent: int | None = choice("N", "Search the staircase by at most N steps of steepest descent from the mean.",
                                 within=Range(0, SAMPLES.high))


@dataclass(frozen=True, repr=False)
class RateChoices(Choices):
    """The choices of `RateSettings`, in the order of its fields."""

    experiment: Any = None
    noise: Any = choice(  # noqa: RUF009 - it is a field
        "TERMS", "Noise model, e.g. 'N 0.003 deg/sqrt(h), Q 0.2 arcsec'.", kind=MODEL, told="identified")
    signal: Any = None
    latitude: float | None = choice("DEG", "Latitude of the site.", within=LATITUDE)
    horizontal: bool = choice("", "The axis is horizontal: find north (needs --latitude).", default=False)
    turned: float = choice("DEG", "Rotation between the two positions.", default=180.0, within=ANGLE)
    near: float = choice("DEG", "Approximate heading, which selects one of the two solutions for north.", default=90.0,
                         within=ANGLE)
    position_method: str = choice("NAME", "Estimator for north and the bias.", default="optimal")
    durations: tuple[float, ...] = choice(
        "S,...", "Measuring times to compare.", default=(), told="", within=TIME, flags=("--measuring-times",),
        old=("--durations",))

"""Choices of the applications, without what the applications need: the help of the command line reads these rows."""

from dataclasses import dataclass
from typing import Any

from allanite.extending import DURATION, INSTANT, MODEL, choice, separated

SECONDS = separated(float, "seconds", example="60,300")

# fmt: off


@dataclass(frozen=True, repr=False)
class VerticalChoices:
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
        "DEG", "Ignore the accelerometers where their tilt differs from the angle by more than this.")
    keep_bias: bool = choice("", "Do not subtract the mean rates of a static recording.", default=False)
    axes: str | None = choice(
        "AXES", "Axes of the file that are forward, sideways and vertical, right-handed, e.g. y,-x,z.", told="x,y,z")


@dataclass(frozen=True, repr=False)
class FitChoices:
    """The choices of `FitSettings`."""

    terms: str = "auto"
    smooth: float = choice("S", "Smoothing window of --derivative-of.", default=60.0, told="60.0")
    blocks: int = choice("", "Number of blocks for cross-validation.", default=5)
    every: bool = choice("", "Keep all powers; skip cross-validation.", default=False)
    split_gaps: bool = choice("", "Treat each stretch between gaps separately.", default=False)
    least: float = choice("", "Effective samples required per regressor.", default=10.0, told="10.0")


@dataclass(frozen=True, repr=False)
class CompensationChoices:
    """The choices of `CompensationSettings`."""

    regressors: tuple[str, ...] = choice("A,B,...", "Columns on which the rate may depend.", default=(), told="")
    degree: int = choice("", "Highest power of a regressor to try.", default=1)
    lags: tuple[float, ...] = choice("S,S,...", "Lags of the regressors, seconds.", kind=SECONDS, default=(), told="")
    derivative_of: tuple[str, ...] = choice("A,B,...", "Columns whose derivative is a regressor.", default=(), told="")
    trend: bool = choice("", "Estimate a linear drift beside the regressors; it is not removed.", default=True,
                         told="trend", flags=("--trend/--no-trend",))
    beside: str | None = choice("FILE", "Read the regressors from this file, with units and times.")
    interpolate: bool = choice(
        "", "Interpolate regressors of another time base to the record's samples.", default=False)
    use: str | None = choice("FILE", "Apply the regressions that --save wrote; no fit.")


@dataclass(frozen=True, repr=False)
class IntervalChoices:
    """The choices of `ExperimentSettings`."""

    interval: float = choice("TIME", "Measuring time.", kind=INSTANT, default=120.0)
    methods: tuple[str, ...] = choice("A,B,...", "Estimators, e.g. mean,optimal.", default=(), told="all")
    target: str = choice("WHAT", "What is estimated of a drifting rate: its mean, centre or start.", default="mean")
    dither: tuple[float, ...] = choice("HZ,...", "Frequencies of the residual dither to remove.", default=(), told="")
    most: int | None = choice("N", "Maximum number of intervals to measure.")


@dataclass(frozen=True, repr=False)
class EstimatorChoices:
    """The choices of `EstimatorSettings`."""

    window: str = choice("NAME", "Window of the hamming estimator.", default="hamming")
    lines: int | None = choice("N", "Number of regression lines of the conditional estimator.")
    quantum: float | None = choice("", "Quantization step of the angle in --unit, if the samples are not counts.")
    certified: bool = choice("", "Search the staircase for the proven optimum.", default=False)
    descent: int | None = choice("N", "Search the staircase by at most N steps of steepest descent from the mean.")


@dataclass(frozen=True, repr=False)
class RateChoices:
    """The choices of `RateSettings`, in the order of its fields."""

    experiment: Any = None
    noise: Any = choice(  # noqa: RUF009 - it is a field
        "TERMS", "Noise model, e.g. 'N 0.003 deg/sqrt(h), Q 0.2 arcsec'.", kind=MODEL, told="identified")
    signal: Any = None
    latitude: float | None = choice("DEG", "Latitude of the site.")
    horizontal: bool = choice("", "The axis is horizontal: find north (needs --latitude).", default=False)
    turned: float = choice("DEG", "Rotation between the two positions.", default=180.0)
    near: float = choice("DEG", "Approximate heading, which selects one of the two solutions for north.", default=90.0)
    position_method: str = choice("NAME", "Estimator for north and the bias.", default="optimal")
    durations: tuple[float, ...] = choice(
        "S,...", "Measuring times to compare.", default=(), told="", flags=("--measuring-times",), old=("--durations",))

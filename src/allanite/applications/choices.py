"""Choices of the applications, without what the applications need: the help of the command line reads these rows."""

from dataclasses import dataclass

from allanite.extending import DURATION, FLAG, INTEGER, NAMES, NUMBER, NUMBERS, WORD, choice, separated

SECONDS = separated(float, "seconds", example="60,300")

# fmt: off


@dataclass(frozen=True, repr=False)
class VerticalChoices:
    """The choices of `VerticalSettings`."""

    method: str = "complementary"
    time_constant: float | None = choice(
        DURATION, "TIME", "Time constant of the filter.", told="the best for the noise")
    bias_time: float | None = choice(
        DURATION, "TIME", "Time of the bias estimate, 1 / sqrt(k2), of a filter that has one.")
    gyro: str | None = choice(
        WORD, "TERMS", "Noise of a gyro, e.g. 'N 0.3 deg/sqrt(h), B 10 deg/h'.", told="identified")
    accelerometer: str | None = choice(
        WORD, "TERMS", "Noise of an accelerometer, e.g. 'N 100 ug/sqrt(Hz), B 50 ug'.", told="identified")
    gate: float | None = choice(
        NUMBER, "DEG", "Ignore the accelerometers where their tilt differs from the angle by more than this.")
    samples: int = 2
    keep_bias: bool = choice(FLAG, "", "Do not subtract the mean rates of a static recording.", default=False)
    axes: str | None = choice(
        WORD, "AXES", "Axes of the file that are forward, sideways and vertical, right-handed, e.g. y,-x,z.",
        told="x,y,z")


@dataclass(frozen=True, repr=False)
class FitChoices:
    """The choices of `FitSettings`."""

    terms: str = "auto"
    smooth: float = choice(
        NUMBER, "S", "Smoothing window of --derivative-of.", default=60.0, told="60.0")
    blocks: int = choice(INTEGER, "", "Number of blocks for cross-validation.", default=5)
    every: bool = choice(FLAG, "", "Keep all powers and lags; skip cross-validation.", default=False)
    split_gaps: bool = choice(FLAG, "", "Treat each stretch between gaps separately.", default=False)
    least: float = choice(NUMBER, "", "Effective samples required per regressor.", default=10.0, told="10.0")


@dataclass(frozen=True, repr=False)
class CompensationChoices:
    """The choices of `CompensationSettings`."""

    regressors: tuple[str, ...] = choice(
        NAMES, "A,B,...", "Columns on which the rate may depend.", default=(), told="")
    degree: int = choice(INTEGER, "", "Highest power of a regressor to try.", default=1)
    lags: tuple[float, ...] = choice(SECONDS, "S,S,...", "Lags of the regressors to try, seconds.", default=(), told="")
    derivative_of: tuple[str, ...] = choice(
        NAMES, "A,B,...", "Columns whose derivative is a regressor.", default=(), told="")
    trend: bool = choice(
        FLAG, "", "Estimate a linear drift beside the regressors; it is not removed.", default=True, told="trend",
        flags=("--trend/--no-trend",))
    beside: str | None = choice(WORD, "FILE", "Read the regressors from this file, with units and times.")
    interpolate: bool = choice(
        FLAG, "", "Interpolate regressors of another time base to the record's samples.", default=False)
    use: str | None = choice(WORD, "FILE", "Apply the regressions that --save wrote; no fit.")


@dataclass(frozen=True, repr=False)
class IntervalChoices:
    """The choices of `ExperimentSettings`."""

    interval: float = choice(NUMBER, "S", "Measuring time.", default=120.0)
    methods: tuple[str, ...] = choice(NAMES, "A,B,...", "Estimators, e.g. mean,optimal.", default=(), told="all")
    target: str = choice(
        WORD, "WHAT", "What is estimated of a drifting rate: its mean, centre or start.", default="mean")
    dither: tuple[float, ...] = choice(
        NUMBERS, "HZ,...", "Frequencies of the residual dither to remove.", default=(), told="")
    most: int | None = choice(INTEGER, "N", "Maximum number of intervals to measure.")


@dataclass(frozen=True, repr=False)
class EstimatorChoices:
    """The choices of `EstimatorSettings`."""

    window: str = choice(WORD, "NAME", "Window of the hamming estimator.", default="hamming")
    lines: int | None = choice(INTEGER, "N", "Number of regression lines of the conditional estimator.")
    quantum: float | None = choice(
        NUMBER, "", "Quantization step of the angle in --unit, if the samples are not counts.")
    certified: bool = choice(FLAG, "", "Search the staircase for the proven optimum.", default=False)

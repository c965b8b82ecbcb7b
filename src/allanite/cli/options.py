"""The options of the command line, each declared once."""

from collections.abc import Callable
from typing import Any

import click

from allanite.core.errors import UsageError
from allanite.reporting.language import ENGLISH, LANGUAGES

from .types import INTEGERS, NAMES, NUMBERS, Band, Duration, Pieces, Ranges, Scale, Taus, Threads, Units

Decorator = Callable[[Any], Any]


def _load_recipe(ctx: click.Context, param: click.Parameter, path: str | None) -> str | None:
    """Take the keys of a TOML file as defaults, which the command line overrides."""
    if path is None:
        return None
    from allanite.study.recipe import load_toml

    known = {p.name for p in ctx.command.params if isinstance(p, click.Option)} - {
        "recipe",
        *OUTPUTS,
        "coefficients",
        *FLAGS,
    }
    choices = load_toml(path)
    for key in choices:
        if key not in known:
            raise UsageError(
                f"unknown key {key!r} in the recipe; known keys: {', '.join(sorted(k for k in known if k))}"
            )
    ctx.default_map = {**(ctx.default_map or {}), **choices}
    return path


def _path(name: str, help: str) -> Decorator:  # noqa: A002 - the word of click
    return click.option(f"--{name}", metavar="PATH", type=click.Path(), help=help)


OUTPUTS = ("report", "plot", "csv", "json")
"""Names of the options that write a result."""

FLAGS = ("lang", "force", "quiet", "strict")
"""Options about writing and the exit code, which a recipe does not hold."""

OPTIONS: dict[str, Decorator] = {
    "file": click.argument("file", type=click.Path()),
    "optional file": click.argument("file", required=False, type=click.Path()),
    "some files": click.argument("files", nargs=-1, type=click.Path(), metavar="[FILE]..."),
    "files": click.argument("files", nargs=-1, required=True, type=click.Path(), metavar="FILE..."),
    "rate": click.option("--rate", "--fs", "rate", type=float, metavar="HZ", help="Sampling rate; overrides the file."),
    "unit": click.option("--unit", type=Units(), metavar="UNIT",
        help="Unit of the samples: deg/s, rad/s, arcsec, g, m/s^2, ...; by sensor or column: gyro=deg/s,accel=g."),
    "kind": click.option("--kind", help="What a sample is: rate, increment, angle, count or value."),
    "scale": click.option("--scale", type=Scale(), metavar="STEP",
        help="Scale factor per count: 0.01 (in --unit) or 0.01deg/s."),
    "channels": click.option("--channels", type=NAMES, metavar="A,B,...",
        help="Columns by name or number.  [default: all recognized]"),
    "time": click.option("--time", help="Column of the time stamps."),
    "dtype": click.option("--dtype", metavar="TYPE",
        help="The file is raw binary of this type: i2, >i2, f4, ..., u4,6i2 for mixed rows, or kfgins."),
    "columns": click.option("--columns", type=int, metavar="N", help="Numbers per row of raw binary."),
    "offset": click.option("--offset", type=int, metavar="BYTES", help="Bytes before the first row of raw binary."),
    "sincos": click.option("--sincos", type=NAMES, metavar="S,C,...",
        help="Columns of sine and cosine, in pairs: their angle is analyzed."),
    "from": click.option("--from", "start", type=float, metavar="S",
        help="Start of the window, s after the first sample."),
    "until": click.option("--until", type=float, metavar="S", help="End of the window, s after the first sample."),
    "quiet-window": click.option("--quiet-window", type=float, metavar="S",
        help="Use the most stationary window of this length."),
    "outliers": click.option("--outliers", metavar="WORD",
        help="mark: exclude everywhere; keep: use everywhere.  [default: exclude from the fit only]"),
    "motion": click.option("--motion", metavar="WORD",
        help="mark: leave out the seconds in which the sensor moves; refuse: no analysis beyond 2 % of them.  "
        "[default: refuse]"),
    "memory": click.option("--memory", metavar="SIZE",
        help="Memory that a record may take, e.g. 1GB; a larger one is read in parts.  [default: half of what is "
        "available]"),
    "terms": click.option("--terms", metavar="QNBKR", help="Noise terms to look for.  [default: auto]"),
    "method": click.option("--method", metavar="NAME",
        help="whittle, or for comparison gls, joint, nnls, piecewise, ls, slopes.  [default: whittle]"),
    "band": click.option("--band", type=Band(), metavar="BAND",
        help="Frequencies to fit: auto (detects filters and disturbed bands), all, or LO,HI in Hz.  [default: auto]"),
    "mask": click.option("--mask", type=Pieces("Hz"), metavar="HZ..HZ,...",
        help="Frequencies that the fit leaves out, beside those it finds: 0.4..2.1,19..20."),
    "level": click.option("--level", type=float, help="Confidence level of intervals.  [default: 0.95]"),
    "recipe": click.option("--recipe", metavar="TOML", type=click.Path(), is_eager=True, callback=_load_recipe,
        help="Read options from a file; the command line overrides them."),
    "statistic": click.option("--statistic", metavar="NAME", help="Statistic of the curve.  [default: oadev]"),
    "taus": click.option("--taus", type=Taus(), metavar="GRID",
        help="octave, decade, log, all, or seconds, e.g. 1,10,100."),
    "m": click.option("--m", type=INTEGERS, metavar="A,B,...", help="Averaging factors, instead of --taus."),
    "to": click.option("--to", metavar="UNIT", help="Unit of the result.  [default: deg/h, ug]"),
    "shown in": click.option("--to", type=NAMES, metavar="UNIT,...",
        help="Units of the coefficients: deg/s, ug/sqrt(Hz), ...  [default: those of data sheets]"),
    "about": click.option("--about", multiple=True, metavar="KEY=VALUE", callback=lambda _, __, lines: lines or None,
        help="For the header of the report: serial, operator, date, temperature, ..."),
    "model": click.option("--model", metavar="TERMS",
        help="Noise model, e.g. 'N 0.01 deg/sqrt(h), GM 0.1 deg/h 20 s'."),
    "sensor": click.option("--sensor", metavar="NAME",
        help="Or a typical gyro: mems, fog or rlg; or a ring laser that counts: gl1 or gl1-smooth."),
    "duration": click.option("--duration", type=Duration(), metavar="TIME", help="Length: 3600, '10 min', 24h."),
    "samples": click.option("--samples", type=int, metavar="N", help="Number of samples."),
    "seed": click.option("--seed", type=click.IntRange(min=0), metavar="N", default=1, show_default=True,
        help="Seed of the random number generator."),
    "accuracy": click.option("--accuracy", type=float, metavar="PERCENT",
        help="Relative standard error of a coefficient to reach.  [default: 10; of a live stream 20]"),
    "threads": click.option("--threads", type=Threads(), default="auto", show_default=True, metavar="N",
        help="Processors to use at once, or auto: all of them. The results are the same."),
    "split-gaps": click.option("--split-gaps", is_flag=True, help="Treat each stretch between gaps separately."),
    "orders": click.option("--orders", type=INTEGERS, metavar="K,K,...", default="128,256", show_default=True,
        help="Harmonics of the angle to estimate."),
    "latitude": click.option("--latitude", type=float, metavar="DEG", help="Latitude of the site."),
    "report": _path("report", "Write a report: HTML, or PDF if PATH ends in .pdf."),
    "plot": _path("plot", "Write the figure: .png, .svg or .pdf."),
    "json": _path("json", "Write all results as JSON; - is standard output."),
    "csv": _path("csv", "Write the numbers as CSV; - is standard output."),
    "coefficients": click.option("--coefficients", "--table", "coefficients", metavar="PATH", type=click.Path(),
        help="Write coefficients and values read off the curve as CSV; - is standard output."),
    "device": click.option("--device", metavar="NAME",
        help="Likely causes of each term in it: stabilizer, mscsg, rlg, fog, mems, accelerometer."),
    "intervals": click.option("--intervals/--no-intervals", default=True,
        help="Confidence intervals; without them no noise is identified."),
    "bias": click.option("--bias", metavar="WORD",
        help="Correct the bias: exact or published (theo1, totdev, mtotdev, ...), model (theobr, theoh); plain: none.  "
        "[default: model for theobr and theoh if the noise is identified, else plain]"),
    "join": click.option("--join", type=float, default=0.2, show_default=True, metavar="SHARE",
        help="Share of the record up to which theoh is the overlapping Allan deviation."),
    "divisor": click.option("--divisor", type=int, default=30, show_default=True, metavar="N",
        help="Divisor of the length for the number of bias ratios of theobr and theoh; 6 as in Stable32."),
    "edf": click.option("--edf", metavar="WORD", default="exact", show_default=True,
        help="Degrees of freedom of the intervals: exact, or published, for the power law found at each time."),
    "power law": click.option("--power-law", is_flag=True,
        help="Show the exponent of the power law that the noise follows at each averaging time."),
    "average": click.option("--average", type=float, metavar="S",
        help="First of all replace the samples by means over this time."),
    "exclude": click.option("--exclude", type=Pieces(), metavar="S..S,...",
        help="Pieces to leave out, s after the first sample: 100..160,300..310; they become gaps."),
    "ranges": click.option("--ranges", type=Ranges(), metavar="N=LO:HI,...",
        help="Averaging times through which method piecewise draws the line of each term, s."),
    "limits file": click.option("--limits", metavar="TOML", type=click.Path(),
        help="Check the coefficients against the limits in this file; exit code 4 if one is exceeded."),
    "strict": click.option("--strict", is_flag=True,
        help="Exit with code 3 if a channel has no result, or no model explains its noise."),
    "lang": click.option("--lang", metavar="LANG", default=ENGLISH,
        help=f"Language of the summary, report and figure: {', '.join(LANGUAGES)}.  [default: {ENGLISH}]"),
    "force": click.option("--force", is_flag=True, help="Overwrite existing files."),
    "quiet": click.option("--quiet", is_flag=True, help="Print errors only, and what is written to standard output."),
    # options of the same name whose meaning differs between verbs
    "several statistics": click.option("--statistic", type=NAMES, metavar="A,B,...", default="oadev",
        show_default=True, help="Statistics."),
    "usual statistic": click.option("--statistic", metavar="NAME", default="oadev", show_default=True,
        help="Statistic."),
    "simulated rate": click.option("--rate", "--fs", "rate", type=float, required=True, metavar="HZ",
        help="Sampling rate."),
    "simulated unit": click.option("--unit", help="Unit of the samples.  [default: deg/h, ug]"),
    "simulated channels": click.option("--channels", type=int, default=1, metavar="N",
        help="Number of independent channels."),
    "simulated outliers": click.option("--outliers", metavar="SHARE SIZE",
        help="Outliers: '0.01% 20' (sigma) or '0.01% 50 deg/h'."),
    "simulated dither": click.option("--dither", metavar="HOW",
        help="Dither added before rounding and removed after: 'random' or '400 Hz 20' (steps)."),
    "dither lines": click.option("--dither", type=NUMBERS, metavar="HZ,...",
        help="Frequencies of the residual dither to remove."),
    "segment window": click.option("--window", metavar="NAME", help="Window of the Welch estimator.  [default: hann]"),
    "sliding window": click.option("--window", type=float, metavar="S",
        help="Length of a window.  [default: a tenth of the record]"),
    "rate window": click.option("--window", metavar="NAME",
        help="Window of the hamming estimator.  [default: hamming]"),
    "planned durations": click.option("--durations", type=Duration(several=True), metavar="A,B,...",
        help="Record lengths.  [default: 10 min,1 h,6 h,24 h]"),
    "measuring durations": click.option("--durations", type=NUMBERS, metavar="S,...",
        help="Measuring times to compare."),
    "measuring interval": click.option("--interval", type=float, metavar="S", help="Measuring time.  [default: 120]"),
    "reading interval": click.option("--interval", type=float, default=10.0, show_default=True, metavar="S",
        help="Sampling interval."),
    "reference rate": click.option("--reference", metavar="RATE",
        help="The true rate, in deg/h or e.g. '12.4 deg/h'."),
    "known bias": click.option("--bias", metavar="RATE", help="Known bias to subtract, in deg/h or e.g. '3 ug'."),
    "reference angle": click.option("--reference", required=True, metavar="COLUMN",
        help="Angle of the reference encoder."),
    "angle unit": click.option("--unit", help="Unit of angles, overrides the header: deg, rad, arcsec ..."),
    "angle time": click.option("--time", default="time", show_default=True, metavar="COLUMN",
        help="Seconds after h = 0."),
    "unexplained": click.option("--unexplained", is_flag=True,
        help="Use the coefficients of channels that no model explains, too."),
    "models": click.option("--model", "models", multiple=True, metavar="TERMS",
        help="Noise of a sensor without a file, e.g. 'N 100 ug/sqrt(Hz), K 10 ug/sqrt(h)'; repeatable."),
    "origin": click.option("--from", "origin", metavar="TARGET",
        help="VALUE is a file of this target: read its coefficients."),
    "filter": click.option("--filter", "filter_name", metavar="NAME",
        help="complementary, second-order, kalman, mahony, madgwick, bortz or accelerometer.  "
        "[default: complementary]"),
    "horizon": click.option("--duration", type=Duration(), metavar="TIME",
        help="Horizon without a recording.  [default: 1 h]"),
    "estimated sigma": click.option("--sigma", type=float, metavar="ARCSEC",
        help="Noise of a sample.  [default: estimated]"),
    "given sigma": click.option("--sigma", type=float, default=1.0, show_default=True, metavar="ARCSEC",
        help="Noise of a sample."),
    "angle trend": click.option("--trend", type=int, default=0, show_default=True,
        help="Degree of a polynomial drift estimated jointly."),
    "trend": click.option("--trend/--no-trend", default=True, show_default=True,
                          help="Estimate a linear drift beside the regressors; it is not removed."),
    "target": click.option("--to", "target", metavar="TARGET",
        help="Program that reads the file: kalibr, vins-mono, px4, ...; 'allanite explain' lists them.  "
        "[default: datasheet]"),
    "corrected angles": _path("corrected", "Write corrected angles as CSV."),
    "corrected record": _path("corrected", "Write the corrected record (of --apply if given)."),
}  # fmt: skip

READING = ("rate", "unit", "kind", "scale", "channels", "time", "dtype", "columns", "offset", "sincos")
"""Options that describe the contents of a file."""

SELECTING = ("average", "exclude", "from", "until", "quiet-window", "outliers", "motion", "memory")
"""Options that select samples."""

IDENTIFYING = ("terms", "method", "ranges", "band", "mask", "level", "strict")
"""Options of every verb that identifies noise."""

RESULTS = (*OUTPUTS, "lang", "force", "quiet")
"""Options of every verb that has a result."""

RECORDING = (*READING, *SELECTING, "recipe", "threads")
"""Options of every verb that reads a recording."""


def options(*wanted: str | Decorator) -> Decorator:
    """Give a command these options, in this order: names in `OPTIONS`, or options of its own."""

    def give(command: Any) -> Any:
        for option in reversed(wanted):
            command = (OPTIONS[option] if isinstance(option, str) else option)(command)
        return command

    return give

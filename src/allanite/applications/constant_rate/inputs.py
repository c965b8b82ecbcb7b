"""From a record to the data of a measurement, and what must be known of it first."""

import math

import numpy as np

from allanite.extending import DataError, Finding, FloatArray, Record, UsageError, say, say_count, spelled, windowing

from .row import EstimatorSettings, Interval, Task

JUMP = 20.0  # median absolute deviations from the median beyond which a sample is called a pulse slip
REPEATED = 0.999  # share of equal samples above which a record of counts is called saturated


def pulse_of(record: Record, options: EstimatorSettings) -> float:
    """Quantum of the angle in samples (of a rate: samples times the sample interval); NaN where there is none."""
    if options.quantum is not None:
        if not (math.isfinite(options.quantum) and options.quantum > 0):
            raise UsageError(f"a quantum must be a positive number of {record.unit}, not {options.quantum!r}")
        readings = options.quantum / (1.0 if record.scale is None else record.scale)
        return readings if record.integrated else readings * record.rate
    return 1.0 if record.kind == "count" else math.nan


def reading_size(record: Record) -> float:
    """Rate of one sample, SI."""
    return record.factor * record.rate if record.integrated else record.factor


def demand_whole(record: Record) -> None:
    """Refuse samples that are not finite."""
    bad = ~np.isfinite(record.values)
    if bad.any():
        raise DataError(say("{bad} of {all} samples of {name!r} are not finite, the first at sample {first}; measure "
                            "between the gaps ({split}), or select a window without them ({window})",
                            bad=int(bad.sum()), all=bad.size, name=record.name, first=int(bad.argmax()),
                            split=spelled("--split-gaps", "gaps=split"), window=windowing()))  # fmt: skip


def interval_of(record: Record, task: Task) -> Interval:
    """The samples of each sample interval, a constant and the dither's sinusoids subtracted."""
    values = record.values
    if record.kind == "angle":
        steps, offset = np.diff(values).astype(np.float64), 0.0
    else:
        offset = float(record.constant)
        steps = np.asarray(values - record.constant, dtype=np.float64)
    return Interval(without_dither(steps, task), offset, reading_size(record), pulse_of(record, task.options))


def without_dither(steps: FloatArray, task: Task) -> FloatArray:
    """The samples less the sinusoids that fit them best, beside a constant."""
    X = task.sinusoids
    if not X.shape[1]:
        return steps
    centred = X - X.mean(axis=0)
    return np.asarray(steps - X @ np.linalg.solve(centred.T @ centred, centred.T @ steps))


def findings_of(record: Record) -> tuple[Finding, ...]:
    """Findings that make a rate of this record doubtful: a dead or saturated output, slipped pulses."""
    values = np.diff(record.values) if record.kind == "angle" else record.values
    if not values.any():
        what = say("every sample is zero: the output is dead, or the axis does not turn")
        remedy = say("check that the sensor is connected")
        return (Finding("dead", what, say("a rate of zero is without evidence"), remedy),)
    typical = float(np.median(values))
    away = np.abs(values - typical)
    equal = float((away == 0).mean())
    if equal >= REPEATED:
        what = say("{percent:.4g} % of the samples are {value:g}", percent=100 * equal, value=typical)
        remedy = say("check the output's range")
        return (Finding("constant", what, say("a saturated or stuck output looks like this"), remedy),)
    spread = float(np.median(away)) or float(away.mean())
    # coarse counts have a spread of nothing: a slip is more than a few pulses in any case
    limit = JUMP * max(spread, 1.0 if record.kind == "count" else 0.0)
    worst = int(away.argmax())
    if away[worst] <= limit:
        return ()
    count = int((away > limit).sum())
    what = say_count(count,
                     "{count} sample with a jump, the first at sample {first}, the largest by {jump:.6g} at sample "
                     "{worst}, where {typical:.3g} is typical",
                     "{count} samples with a jump, the first at sample {first}, the largest by {jump:.6g} at sample "
                     "{worst}, where {typical:.3g} is typical", first=int((away > limit).argmax()),
                     jump=float(away[worst]), worst=worst, typical=spread)  # fmt: skip
    consequence = say("missing or doubled pulses enter the rate in full")
    return (Finding("slip", what, consequence, say("choose a window without them")),)

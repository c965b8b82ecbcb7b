"""Resampling of channels to the sample times of a record, if requested."""

from dataclasses import replace

import numpy as np

from allanite.extending import DataError, Record, Recording, public, say

from .regressor import FloatArray


@public
def aligned(along: Recording, record: Record) -> Recording:
    """The channels at the intervals of `record`: means if they are faster, otherwise linear interpolation.

    Values before the first sample or after the last one are NaN, and so are values next to a missing sample. Times are
    those of `start`, or zero.

    Raises
    ------
    DataError
        A channel does not overlap the record, or is an angle.

    Examples
    --------
    >>> temp = Record([20.0, 22.0, 24.0], rate=0.5, unit="degC", name="temp")
    >>> gyro = Record(np.zeros(6), rate=1.0, unit="deg/h", name="z")
    >>> aligned(Recording((temp,)), gyro)["temp"].values.tolist()
    [20.0, 21.0, 22.0, 23.0, 24.0, nan]
    """
    at = np.arange(record.size) / record.rate
    found = []
    for other in along:
        if other.integrated:
            raise DataError(
                say("{name!r} is of kind {kind}; only plain samples can be resampled", name=other.name, kind=other.kind)
            )
        x, faster = np.asarray(other.values, dtype=np.float64), other.rate > record.rate
        when = at + ((record.start or 0.0) - (other.start or 0.0))
        if faster:
            values = _means(x, other.rate, when, record.rate)
        else:
            values = np.interp(when, np.arange(x.size) / other.rate, x, left=np.nan, right=np.nan)
        if np.isnan(values).all():
            raise DataError(
                say("{first!r} and {second!r} do not overlap in time", first=other.name, second=record.name)
            )
        way = say("means") if faster else say("linear interpolation")
        what = say("resampled from {rate:.9g} Hz to the times of {name!r} by {way}",
                   rate=other.rate, name=record.name, way=way)  # fmt: skip
        found.append(Record(
            values, record.rate, other.unit, scale=other.scale, name=other.name, start=record.start,
            history=(*other.history, what),
        ))  # fmt: skip
    return replace(along, records=tuple(found))


def _means(x: FloatArray, rate: float, when: FloatArray, wanted: float) -> FloatArray:
    """Means over the intervals that begin at `when`: differences of the integral; NaN where a reading is missing."""
    edges = np.arange(x.size + 1) / rate
    lost = np.concatenate(([0.0], np.cumsum(np.isnan(x))))
    integral = np.concatenate(([0.0], np.cumsum(np.nan_to_num(x)))) / rate
    spans = (when, when + 1 / wanted)
    begin, end = (np.interp(t, edges, integral, left=np.nan, right=np.nan) for t in spans)
    missing = np.interp(spans[1], edges, lost) - np.interp(spans[0], edges, lost)
    return np.where(missing > 0, np.nan, (end - begin) * wanted)

"""The angle whose sine and cosine were recorded: of a resolver, or of an encoder with sinusoidal signals."""

import math
from dataclasses import replace
from itertools import islice

import numpy as np

from allanite.core.arrays import FloatArray, IntArray
from allanite.core.errors import DataError
from allanite.core.record import Record, Recording
from allanite.core.validity import Finding
from allanite.phrases.phrase import say, say_count

FAINT = 0.5
"""Deviation of the amplitude from its median, relative to it, beyond which a sample is not one of sine and cosine."""

FEW_DROPOUTS = 0.01  # largest share of such samples, which are marked as missing
LARGEST_STEP = math.pi / 2  # rotation between samples above which turns cannot be counted with certainty
MEANS = 8  # number of steps whose mean is the speed of rotation
SECTORS = 36  # number of sectors of a turn
LEAST_SECTORS = 27  # sectors that the angle must reach, for offsets and gains to be told from the angle
LEAST_ERROR = 1e-5  # angle error, rad, that is not worth a warning


def with_angles(recording: Recording, pairs: int, kind: str) -> Recording:
    """The recording whose first 2 `pairs` records, sine and cosine in turn, are replaced by their angles."""
    records, notes, findings = [], list(recording.notes), list(recording.findings)
    for sine, cosine in zip(*(islice(recording.records, i, 2 * pairs, 2) for i in (0, 1)), strict=True):
        angle, defects, note = angle_of(sine, cosine, kind)
        records.append(angle)
        notes.append(note)
        findings += defects
    others = recording.records[2 * pairs :]
    return replace(recording, records=(*records, *others), notes=tuple(notes), findings=tuple(findings))


def angle_of(sine: Record, cosine: Record, kind: str = "value") -> tuple[Record, list[Finding], str]:
    """The unwrapped angle in rad, findings about sine and cosine, and what could be checked."""
    s, c = (np.asarray(record.values, dtype=np.float64) for record in (sine, cosine))
    name = f"angle {sine.name} {cosine.name}"
    size = np.hypot(s, c)
    loud, findings = _loud(size, sine, name)
    wrapped = np.arctan2(s[loud], c[loud])
    values = np.full(s.size, np.nan)
    values[loud] = _unwrapped(wrapped, loud, sine.rate, name)
    errors, note = _errors(values[loud], size[loud], name)
    history = (*sine.history, say("angle of sine {sine!r} and cosine {cosine!r}", sine=sine.name, cosine=cosine.name))
    angle = Record(values, sine.rate, "rad", kind, name=name, start=sine.start, history=history)
    return angle, findings + errors, note


def _loud(size: FloatArray, sine: Record, name: str) -> tuple[IntArray, list[Finding]]:
    """Samples with the amplitude of a sine and cosine, and a finding if a few have not."""
    known = np.isfinite(size)
    if not known.any():
        raise DataError(say("sine and cosine {name} have no sample in common", name=name))
    usual = float(np.median(size[known]))
    wrong = known & ~(np.abs(size - usual) <= FAINT * usual)
    count = int(wrong.sum())
    if usual == 0 or count > FEW_DROPOUTS * known.sum():
        raise DataError(say(
            "{name} are not the sine and cosine of an angle: their amplitude is {least:.4g} to {most:.4g} with a "
            "median of {usual:.4g}; name the sine first and subtract offsets of the converter",
            name=name, least=float(size[known].min()), most=float(size[known].max()), usual=usual,
        ))  # fmt: skip
    loud = np.flatnonzero(known & ~wrong)
    if not count:
        return loud, []
    what = say_count(count,
                     "{name}: {count} sample without the amplitude of sine and cosine, the first at {start:.6g} s",
                     "{name}: {count} samples without the amplitude of sine and cosine, the first at {start:.6g} s",
                     name=name, start=int(wrong.argmax()) / sine.rate)  # fmt: skip
    return loud, [Finding("amplitude", what, say("they are treated as missing"))]


def _unwrapped(wrapped: FloatArray, there: IntArray, rate: float, name: str) -> FloatArray:
    """The angle without jumps of a turn."""
    steps, apart = np.remainder(np.diff(wrapped) + np.pi, 2 * np.pi) - np.pi, np.diff(there)
    fast = np.flatnonzero((apart == 1) & (np.abs(steps) > LARGEST_STEP))
    if fast.size:
        raise DataError(say(
            "{name}: the angle turns by {step:.3g} deg from {start:.6g} s to the next sample ({count} such steps); "
            "beyond 90 deg turns cannot be counted with certainty: sample faster, or name the sine first",
            name=name, step=math.degrees(abs(steps[fast[0]])), start=there[fast[0]] / rate, count=fast.size,
        ))  # fmt: skip
    # the fastest rotation in rad per sample, as a mean over a few steps
    near = steps[apart == 1]
    means = near if near.size < MEANS else np.convolve(near, np.full(MEANS, 1 / MEANS), mode="valid")
    speed = float(np.abs(means).max(initial=0.0))
    wide = np.flatnonzero((apart > 1) & (np.maximum(speed * apart, np.abs(steps)) > LARGEST_STEP))
    if wide.size:
        raise DataError(say("{name}: the angle may have turned by more than 90 deg while samples are missing, from "
                            "{start:.6g} s to {end:.6g} s, so that its turns cannot be counted; read the parts before "
                            "and after as files of their own",
                            name=name, start=there[wide[0]] / rate, end=there[wide[0] + 1] / rate))  # fmt: skip
    return np.concatenate((wrapped[:1], wrapped[0] + np.cumsum(steps)))


def _errors(angle: FloatArray, size: FloatArray, name: str) -> tuple[list[Finding], str]:
    """The angle errors by offsets, unequal gains and a phase that is not 90 deg, from the amplitude over a turn."""
    # To first order they change the amplitude as much as the angle: offsets once per turn, the others twice.
    read = say("{name}: sine and cosine are used as an angle in rad", name=name)
    turn = np.remainder(angle, 2 * np.pi)
    sectors = np.unique((turn * (SECTORS / (2 * np.pi))).astype(np.int64)).size
    if sectors < LEAST_SECTORS:
        reach = math.degrees(float(np.ptp(angle)))
        return [], say(
            "{note}; it covers {reach:.3g} deg, too little to check offsets and gains: a difference of the gains of "
            "1 % changes its scale by up to 1 %, an offset adds to it",
            note=read, reach=min(reach, 360.0),
        )  # fmt: skip
    waves = np.stack([np.ones_like(turn), *(f(k * turn) for k in (1, 2) for f in (np.cos, np.sin))], axis=1)
    mean, *rest = np.linalg.lstsq(waves, size, rcond=None)[0]
    cos1, sin1, cos2, sin2 = np.array(rest) / mean
    noise = float(np.std(size - waves @ np.array([mean, *rest]))) / mean * math.sqrt(2 / size.size)
    errors = math.hypot(cos1, sin1), math.hypot(cos2, sin2)
    if max(errors) < max(5 * noise, LEAST_ERROR):
        return [], read
    once, twice = (math.degrees(error) * 3600 for error in errors)
    what = say("{name}: offsets of {sine:.3g} % (sine) and {cosine:.3g} % (cosine) of the amplitude, gains different "
               "by {gain:.3g} %, phase {phase:.3g} deg from 90 deg", name=name, sine=100 * sin1, cosine=100 * cos1,
               gain=200 * cos2, phase=math.degrees(2 * sin2))  # fmt: skip
    effect = say("errors of the angle of up to {once:.3g} arcsec once and {twice:.3g} arcsec twice per turn",
                 once=once, twice=twice)  # fmt: skip
    return [Finding("imbalance", what, effect, say("correct sine and cosine before they are recorded"))], read

"""What several of these tests check."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from tests import examples

import allanite as al
from allanite.readers.parts import opened, whole_findings


def tried(most, **drawn):
    """Make a test of so many examples, all of which write in one folder."""
    how = settings(
        max_examples=examples(most), deadline=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    )  # fmt: skip
    return lambda test: how(given(**drawn)(test))


def noted(recording, *words):
    """Whether one of the notes has all these words."""
    return any(all(word in note for word in words) for note in recording.notes)


def gathered(path, size, choices):
    """The samples of each channel, the beat, notes and findings of a file read in parts."""
    reader = opened(path, "1kB", choices)
    pieces = list(reader.pieces(size))
    samples = [
        np.concatenate([np.r_[np.full(lost, np.nan), part[i]] if lost else part[i] for lost, part in pieces])
        for i in range(len(reader.heads))
    ]
    beat = reader.clock.beat()
    return samples, beat, reader.sense.notes(beat), whole_findings(reader)


def assert_as_whole(path, size, choices, closeness=1e-12, strict=False):
    """Check that a file read in parts has the samples, clock, notes and findings of the whole; strict: of one type."""
    whole = al.read(path, **choices)
    samples, beat, notes, findings = gathered(path, size, choices)
    for values, record in zip(samples, whole, strict=True):
        np.testing.assert_array_equal(values, record.values, strict=strict)
    assert beat.rate == pytest.approx(whole[0].rate, rel=closeness)
    assert beat.start == whole[0].start
    assert [(f.name, f.what) for f in findings] == [(f.name, f.what) for f in whole.findings]
    assert notes == whole.notes

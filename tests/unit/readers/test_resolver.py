"""The angle of sine and cosine columns."""

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import refused, rows

import allanite as al
from allanite.readers.columns.resolver import angle_of

RATE = 50.0


def pair(angle, sine=(0.0, 1.0), cosine=(0.0, 1.0), lag=0.0):
    """Records of both, each with offset and gain."""
    values = sine[0] + sine[1] * np.sin(angle + lag), cosine[0] + cosine[1] * np.cos(angle)
    return [al.Record(v, RATE, "V", "value", name=n) for v, n in zip(values, ("s", "c"), strict=True)]


def turning(n=5000, speed=0.02, noise=1e-4):
    return 0.3 + speed * np.arange(n) + noise * np.random.default_rng(1).standard_normal(n)


@rows("true", [turning(), -turning(), 3.1 + 0.2 * np.sin(np.arange(3000) / 50), turning(speed=0.0)])
def test_the_angle_is_unwrapped(true):
    angle, findings, _ = angle_of(*pair(true, (0, 2.5), (0, 2.5)))
    turns = np.round((angle.values[0] - true[0]) / (2 * np.pi)) * 2 * np.pi
    assert np.allclose(angle.values - turns, true, atol=1e-12)
    assert (angle.unit, angle.kind, angle.signal.name, findings) == ("rad", "value", "angle", [])


def test_missing_samples_stay_missing_and_the_turns_are_kept():
    true = turning()
    sine, cosine = pair(true)
    sine.values[100:110] = np.nan
    cosine.values[108:115] = np.nan
    angle, _, _ = angle_of(sine, cosine)
    lost = np.isnan(angle.values)
    assert np.flatnonzero(lost).tolist() == list(range(100, 115))
    assert np.allclose(angle.values[~lost], true[~lost], atol=1e-12)


GAP = (np.arange(5000) >= 100) & (np.arange(5000) < 190)  # in which it turns by 1.8 rad


@rows("sine, cosine, words", [
    (np.where(GAP, np.nan, np.sin(turning())), np.cos(turning()), "turned by more than 90 deg .* from 1.98 s to 3.8 s"),
    *((np.sin(fast), np.cos(fast), "turns cannot be counted with certainty")
      for fast in (turning(speed=1.7), turning(speed=3.0), turning(speed=-2.0))),
    (*np.random.default_rng(1).standard_normal((2, 1000)), "not the sine and cosine of an angle"),
], ids=["a gap", "fast", "faster", "backwards", "noise"])  # fmt: skip
def test_what_gives_no_angle_is_refused(sine, cosine, words):
    records = (al.Record(values, RATE, "V", "value", name=name) for name, values in (("s", sine), ("c", cosine)))
    refused(al.DataError, words, lambda: angle_of(*records))


def test_a_few_dropouts_are_marked():
    sine, cosine = pair(turning())
    sine.values[700], cosine.values[700] = 0.0, 0.01
    angle, (finding,), _ = angle_of(sine, cosine)
    assert (np.flatnonzero(np.isnan(angle.values)).tolist(), finding.name) == ([700], "amplitude")
    assert "1 sample without the amplitude of sine and cosine, the first at 14 s" in finding.what


@rows("sine, cosine, lag, words", [
    ((0.01, 1.0), (0.0, 1.0), 0.0, "offsets of 1 % (sine)"), ((0.0, 1.0), (-0.02, 1.0), 0.0, "-2 % (cosine)"),
    ((0.0, 0.99), (0.0, 1.0), 0.0, "gains different by 1"),
    ((0.0, 1.0), (0.0, 1.0), 0.01, "phase 0.573 deg from 90 deg"),
])  # fmt: skip
def test_imbalance_is_measured_and_its_angle_error_is_right(sine, cosine, lag, words):
    true = turning(20000)
    angle, (finding,), _ = angle_of(*pair(true, sine, cosine, lag))
    error = np.ptp(angle.values - true) / 2
    said = [float(w) for w in finding.consequence.split() if w.replace(".", "").replace("e+", "").isdigit()]
    assert finding.name == "imbalance"
    assert words in finding.what
    assert max(said) == pytest.approx(np.degrees(error) * 3600, rel=0.05)


def test_a_small_range_cannot_be_checked_and_says_so():
    _, findings, note = angle_of(*pair(0.1 + 1e-3 * np.random.default_rng(1).standard_normal(2000), (0, 1.1)))
    assert not findings
    assert "too little to check offsets and gains" in note


def test_columns_of_two_axes_become_two_angles(tmp_path):
    path, true, kept = tmp_path / "skt.csv", turning(3000), np.r_[:500, 510:3000]
    columns = (np.arange(3000) / RATE, np.sin(true), np.cos(true), 9 * np.sin(2 * true), 9 * np.cos(2 * true))
    np.savetxt(path, np.column_stack(columns)[kept], "%.12g", ",", header="t [s],s1 [V],c1 [V],s2,c2", comments="")
    recording = al.read(path, sincos=("s1", "c1", "s2", "c2"))
    assert [(r.name, r.kind, r.unit, r.size) for r in recording] == [
        ("angle s1 c1", "value", "rad", 3000), ("angle s2 c2", "value", "rad", 3000)
    ]  # fmt: skip
    assert np.isnan(recording[0].values[500:510]).all()
    assert np.allclose(recording[0].values[kept], true[kept], atol=1e-9)
    assert any("used as an angle in rad" in note for note in recording.notes)
    ends(run("info", path, "--sincos", "s1,c1", "--kind", "angle"), 0, "gyroscope, angle in rad")


@rows("given, words", [
    ({"sincos": ["s1", "c1", "s2"]}, r"pairs of columns, the sine first, for example sincos=\['sin', 'cos'\]"),
    ({"sincos": ["s1", "c1"], "channels": ["s1"]}, "channels has no meaning"),
    ({"sincos": ["s1", "c1"], "unit": "deg"}, "unit has no meaning"),
    ({"sincos": ["s1", "c1"], "kind": "rate"}, "its kind is 'value'"),
    ({"sincos": ["s1", "nothing"]}, "no column 'nothing'"),
])  # fmt: skip
def test_impossible_choices_are_refused(write, given, words):
    path = write("s1,c1,s2\n" + "\n".join(f"{np.sin(i)},{np.cos(i)},0" for i in np.arange(300) / 50))
    refused(al.UsageError, words, lambda: al.read(path, rate=10.0, **given))

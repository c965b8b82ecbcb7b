"""The sampling rate out of stamps: even grids, jitter, losses, clocks that drift, units that are not said."""

import re

import numpy as np
import pytest
from tests.rows import refused, rows

from allanite.core.errors import DataError, UsageError
from allanite.readers import read


@pytest.fixture
def stamped(table):
    def stamped(stamps, header="time [s]"):
        values = np.random.default_rng(3).integers(-9, 9, len(stamps)) + 0.5
        return table(f"{header},gx [deg/s]", np.asarray(stamps).tolist(), values)

    return stamped


def test_rate_is_intervals_over_time_in_spite_of_jitter(stamped):
    jitter = np.random.default_rng(1).uniform(-0.3, 0.3, 1000)
    jitter[[0, -1]] = 0
    record = read(stamped(5.0 + (np.arange(1000) + jitter) * 0.01))["gx"]
    assert (record.rate, record.start) == (pytest.approx(100.0, rel=1e-9), 5.0)
    # coarse stamps are fine while they follow the grid
    assert read(stamped(np.arange(2001) * 5 // 2, "t_ms"))["gx"].rate == pytest.approx(400.0)
    epoch = 1_700_000_000_000_000_001 + np.arange(1000) * 1_000_003
    assert read(stamped(epoch, "stamp [ns]"))["gx"].rate == pytest.approx(1e9 / 1_000_003, rel=1e-14)


def only(recording, name):
    assert [finding.name for finding in recording.findings] == [name]
    (finding,) = recording.findings
    assert all((finding.what, finding.consequence, finding.remedy))
    return finding


def test_a_gap_is_marked_with_place_size_and_remedy(stamped):
    stamps = np.arange(1000) * 0.01
    stamps[600:] += 0.5
    recording = read(stamped(stamps))
    record = recording["gx"]
    assert (record.size, record.rate) == (1050, pytest.approx(100.0))
    assert np.flatnonzero(np.isnan(record.values)).tolist() == list(range(600, 650))
    assert record.history == ("50 missing samples marked as gaps",)
    finding = only(recording, "missing samples")
    assert finding.place == pytest.approx((6.0, 6.5))
    for words in ("50 samples", "4.8 %", "1 gap", "of 0.5 s at 6 s", "time='none'"):
        assert words in str(finding)
    assert any("50 missing intervals" in note for note in recording.notes)
    closed = read(stamped(stamps), time="none", rate=100)
    assert (closed["gx"].size, closed.findings) == (1000, ())
    recording = read(stamped(np.delete(np.arange(1001), 500) * 0.01))
    assert "1 sample (0.1 %) missing in 1 gap" in only(recording, "missing samples").what
    assert np.isnan(recording["gx"].values[500])


def test_lost_counts_become_increments(write):
    path = write("t [s],pulses\n" + "".join(f"{k / 10},{k % 7}\n" for k in range(100) if k not in (50, 51)))
    record = read(path, unit="arcsec", kind="count", scale=0.1, channels=["pulses"])["pulses"]
    assert (record.kind, record.scale, record.values.dtype) == ("increment", 0.1, np.float64)
    assert np.flatnonzero(np.isnan(record.values)).tolist() == [50, 51]


def test_a_clock_that_is_set_or_stands_is_refused(stamped):
    stamps = np.arange(1000) * 0.01
    stamps[500:] -= 3
    words = r"1 time stamp of column 'time \[s\]' is earlier than the previous one, the first in row 501.*rate="
    refused(DataError, words, lambda: read(stamped(stamps)))
    forward = np.arange(1000) * 0.01
    forward[3:] += 1.7e9
    refused(DataError, r"jump by 1\.7e\+09 s before row 4 of the data", lambda: read(stamped(forward)))
    assert "is ignored" in only(read(stamped(forward), rate=100), "missing samples").consequence
    missing = np.where(np.arange(50) == 7, np.nan, np.arange(50.0))
    refused(DataError, "no time stamp in 1 of 50 rows, the first in row 8", lambda: read(stamped(missing)))
    refused(UsageError, r"all time stamps .* are equal .*rate=100", lambda: read(stamped(np.zeros(50))))


def test_stamps_of_whole_seconds(stamped):
    recording = read(stamped(np.delete(np.arange(1000) // 5, np.s_[500:510])))  # a second is missing
    assert recording["gx"].rate == 5.0
    assert [f.name for f in recording.findings] == ["missing samples", "coarse time stamps"]
    assert np.flatnonzero(np.isnan(recording["gx"].values)).tolist() == list(range(500, 510))


@pytest.mark.slow("takes more than half a second")
def test_a_drifting_clock_is_no_gap(stamped):
    k = np.arange(100_000)
    recording = read(stamped((k + 3e-10 * k**2) * 0.01 + 0.001))  # 60 ppm over the record
    assert (recording["gx"].rate, recording.findings) == (pytest.approx(100.0, rel=1e-4), ())
    assert recording["gx"].size == 100_000


def test_a_late_stamp_is_no_loss(stamped):
    stamps = np.arange(1000) * 0.01
    stamps[500:520] = stamps[520] - 1e-4 * np.arange(20, 0, -1)  # the logger wrote to its card for 0.2 s
    record = read(stamped(stamps))["gx"]
    assert (record.size, record.rate) == (1000, pytest.approx(100.0))


EVEN = 417_300_000 + np.arange(300) * 8000
DAMAGES = {  # rows, and what their stamps become
    "a digit lost": {120: lambda t: int(str(t)[1:])}, "a digit too many": {120: lambda t: int(f"9{t}")},
    "a little early": {1: lambda t: t - 60_000}, "a little late": {298: lambda t: t + 60_000},
    "zero": {7: lambda _: 0}, "the first, early": {0: lambda t: t - 400_000_000},
    "the first, late": {0: lambda t: t + 60_000}, "the last, early": {299: lambda t: t - 60_000},
    "the last, late": {299: lambda t: int(f"{t}7")}, "two": {50: lambda t: t // 10, 210: lambda t: t * 10},
    "two near each other": {50: lambda t: t - 10**6, 53: lambda t: t + 10**6},
}  # fmt: skip


@rows("unit, size", [("us", 1), ("ns", 1000), ("ms", 0.001), ("s", 1e-6)])
@rows("damages", DAMAGES.values(), ids=list(DAMAGES))
def test_a_lone_stamp_that_is_far_off_is_set_by_its_neighbours(stamped, damages, unit, size):
    stamps = EVEN.copy()
    for row, damage in damages.items():
        stamps[row] = damage(stamps[row])
    scaled = stamps * size if size < 1 else stamps.astype(np.int64) * size
    if unit == "ms":
        scaled = np.rint(scaled).astype(np.int64)
    recording = read(stamped(scaled, f"time [{unit}]"))
    record, plain = recording["gx"], read(stamped(EVEN, "time [us]"))["gx"]
    assert record.values.tolist() == plain.values.tolist()
    assert (record.rate, record.start) == (pytest.approx(plain.rate), pytest.approx(plain.start))
    finding = only(recording, "damaged time stamps")
    assert f"row {min(damages) + 1} of the data" in finding.what
    assert str(scaled[min(damages)].item()) in finding.what


@rows("stamps, name", [
    (np.random.default_rng(5).permutation(EVEN), "reversed time stamps"),
    (np.insert(np.delete(EVEN, 50), 180, EVEN[50]), "reversed time stamps"),
    (EVEN - 500_000 * (np.arange(300) < 1), "missing samples"),
    (EVEN + 500_000 * (np.arange(300) > 199), "missing samples"),
], ids=["shuffled", "one moved", "begun early", "late"])  # fmt: skip
def test_gaps_and_rows_out_of_order_are_not_damage(stamped, stamps, name):
    only(read(stamped(stamps, "time [us]")), name)


def test_a_clock_of_32_bits_starts_again(stamped):
    stamps = (2**32 - 5_000_000 + np.arange(1000) * 10_000) % 2**32
    recording = read(stamped(stamps, "micros"))
    assert recording["gx"].rate == pytest.approx(100.0)
    assert any("wraps around at 2^32" in note for note in recording.notes)
    assert recording.findings == ()


def test_of_several_clocks_the_steadiest_is_taken_and_that_is_said(table):
    k, rng = np.arange(500), np.random.default_rng(1)
    columns = (np.sort(k * 0.025 + rng.uniform(0, 0.04, 500)), k / 40, k // 40, rng.normal(size=500))
    recording = read(table("receive_time [s],stamp [s],coarse_stamp [s],gx [deg/s]", *columns))
    assert recording["gx"].rate == pytest.approx(40.0)
    note = next(note for note in recording.notes if "used as the clock" in note)
    assert note.startswith("column 'stamp [s]' is used as the clock, of 3")
    assert "repeats 98 % of its time stamps" in note
    assert recording.findings == ()


def test_a_packet_counter_tells_the_losses_but_not_the_rate(table):
    def counted(steps):
        counts = np.concatenate(([7], 7 + np.cumsum(steps))) % 65536
        return table("Packet number,gx [deg/s]", counts, np.arange(len(counts)) % 5 + 0.5)

    steps = np.tile([1, 2, 1, 3], 100)
    path = counted(steps)
    refused(UsageError, r"counter column 'Packet number' shows which samples are missing.*rate=100", lambda: read(path))
    recording = read(path, rate=100)
    assert recording.channels == ("gx",)
    assert recording["gx"].size == steps.sum() + 1
    finding = only(recording, "missing samples")
    assert "according to the counter column 'Packet number'" in finding.what
    assert np.isnan(recording["gx"].values[:8]).tolist() == [False, False, True, False, False, True, True, False]
    # a counter that starts again or counts by tens
    steps = np.ones(70_000, dtype=int)
    steps[1000] = 4
    assert read(counted(steps), rate=100)["gx"].size == 70_004
    steps = np.full(500, 10)
    steps[100] = 30
    assert read(counted(steps), rate=100)["gx"].size == 503
    assert read(counted(np.full(500, 10)), rate=100).findings == ()


def test_with_a_counter_bursty_stamps_give_the_rate_of_the_sensor(table):
    counts = np.cumsum(np.where(np.arange(1000) % 10 == 1, 2, 1)) - 1
    stamps = counts // 20 * 0.2 + 0.001 * (counts % 20)
    stamps[-1] = counts[-1] * 0.01
    record = read(table("time,seq,gx [deg/s]", stamps.round(3), counts, counts % 3 + 0.5))["gx"]
    assert (record.rate, record.size) == (pytest.approx(100.0), counts[-1] + 1)


@rows(("step", "unit", "rate"), [(10, "ms", 100), (5, "ms", 200), (10_000, "us", 100), (2500, "us", 400)])
def test_integer_stamps_without_unit(stamped, step, unit, rate):
    recording = read(stamped(np.arange(200) * step, "stamp"))
    assert recording["gx"].rate == pytest.approx(rate)
    assert any(f"assumed to be in {unit}" in note for note in recording.notes)
    assert any("assumed to be in seconds" in note for note in read(stamped(np.arange(200) * 0.25 + 0.1, "t")).notes)
    stamps = EVEN.copy()
    stamps[-1] = stamps[-1] * 1000  # damaged: the unit is that of the others
    recording = read(stamped(stamps, "stamp"))
    assert recording["gx"].rate == pytest.approx(125.0)
    only(recording, "damaged time stamps")


@rows("step", [1, 200, 200_000, 100_000_000_000])
def test_ambiguous_integer_stamps_are_asked_for(stamped, step):
    path = stamped(np.arange(200) * step, "stamp")
    refused(UsageError, r"time='stamp\[UNIT\]'", lambda: read(path))
    assert read(path, time="stamp[us]")["gx"].rate == pytest.approx(1e6 / step)
    if step > 1:  # that counts no rows
        refused(UsageError, r"the rate given, 50\.0 Hz, contradicts", lambda: read(path, rate=50))
    assert read(path, rate=50, time=None if step == 1 else "none")["gx"].rate == 50.0


def test_the_given_rate_wins_and_a_small_difference_is_a_finding(stamped):
    path = stamped(np.arange(200) * 0.01)
    assert not read(path, rate=100.05).findings
    (finding,) = read(path, rate=100.5).findings
    assert re.search(r"100\.5 Hz is used.* 100\.0 Hz", finding.what)
    # a rate that contradicts the time stamps is refused with a cure
    words = r"200\.0 Hz, contradicts the time stamps .*, 100\.0 Hz: omit it.*time='none'$"
    refused(UsageError, words, lambda: read(path, rate=200))
    assert (read(path, rate=200, time="none")["gx"].rate, read(path)["gx"].rate) == (200.0, pytest.approx(100.0))
    # time option
    path = stamped(np.arange(200) * 0.01, "foo")
    assert read(path, time="foo")["gx"].rate == pytest.approx(100.0)
    assert read(path, time="1[ms]")["gx"].rate == pytest.approx(1e5)
    refused(UsageError, "no column 'bar'", lambda: read(path, time="bar"))
    refused(UsageError, "not a unit of time", lambda: read(path, time="foo[kg]"))
    refused(UsageError, "sampling rate", lambda: read(stamped(np.arange(200) * 0.01), time="none"))
    assert read(stamped(np.arange(200) * 0.01), time="none", rate=7)["gx"].start is None


def test_a_temperature_called_t_is_no_clock(write):
    path = write("gx [deg/s],T\n" + "1.5,36.0\n2.5,36.5\n" * 20)
    assert read(path, rate=10).channels == ("gx",)
    refused(UsageError, "sampling rate", lambda: read(path))


@rows("row", [0, 1500, 2998])
def test_a_time_stamp_that_no_clock_counts_is_named(row, tmp_path):
    stamps = np.arange(3000) / 100
    stamps[row : row + 2] = 1e200
    np.savez(tmp_path / "a.npz", **{"t [s]": stamps, "gx [deg/s]": np.random.default_rng(1).standard_normal(3000)})
    refused(DataError, r"jump by -?1e\+200 s before row \d+ of the data; pass rate=", lambda: read(tmp_path / "a.npz"))
    assert read(tmp_path / "a.npz", rate=100.0)["gx"].size == 3000


def test_a_slow_log_may_have_dropped_samples(stamped):
    hint = "if the logger drops samples without averaging, N is too large by up to sqrt(f_sensor/f_log)"
    assert hint in read(stamped(np.arange(200) * 0.25)).notes
    assert hint not in read(stamped(np.arange(200) * 0.1)).notes
    assert hint not in read(stamped(np.arange(200) * 0.25), kind="increment", unit="deg").notes

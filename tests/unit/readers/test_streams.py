"""Which table of a file is wanted, whatever the format."""

import numpy as np
from tests.rows import refused

from allanite.core.errors import UsageError
from allanite.phrases.phrase import Phrase
from allanite.readers.columns.column import column
from allanite.readers.columns.containers import Stream, stream_recording
from allanite.readers.columns.table import FileTable
from allanite.readers.options import Options

RNG = np.random.default_rng(4)


def stream(name, count=300, **about):
    table = FileTable((column("gx", RNG.normal(size=count), 1, unit="deg/s"),), 100.0)
    return Stream(name, count, ("gx",), lambda: table, **about)


def chosen(found, *channels):
    notes = stream_recording(found, Options(channels=channels or None)).notes
    assert all(isinstance(note, Phrase) for note in notes)
    return next(note for note in notes if note.startswith("samples of ")).removeprefix("samples of ").split()[0]


def test_the_likeliest_is_taken_if_it_is_long_enough():
    known, named, other = stream("known", likely=2), stream("named"), stream("other", likely=0)
    assert (chosen([other, named, known]), chosen([other, named, stream("known", 9, likely=2)])) == ("known", "named")
    words = r"2 tables that may be meant.*named \(300 rows\), again \(300 rows\)"
    refused(UsageError, words, lambda: chosen([other, named, stream("again")]))


def test_names_may_begin_with_a_slash_and_differ_by_case_or_type():
    found = [stream("/imu"), stream("/IMU"), stream("/raw/lab/Counts"), stream("/raw/lab/Rates", type="lab/Rates")]
    assert (chosen(found, "/imu"), chosen(found, "IMU")) == ("/imu", "/IMU")
    assert [chosen(found, f"{name}/gx") for name in ("/imu", "/IMU")] == ["/imu", "/IMU"]
    assert chosen(found, "/raw/lab/Rates") == "/raw/lab/Rates"
    words = r"/raw/lab/Counts \(300 rows\), /raw/lab/Rates of type lab/Rates \(300 rows"
    refused(UsageError, words, lambda: chosen(found, "/raw"))
    refused(UsageError, r"contains /imu", lambda: chosen(found, "/gyro"))


def test_what_cannot_be_decoded_is_refused_if_it_is_meant():
    lost, other = stream("/imu", type="lab/Imu", likely=0, why="no definition"), stream("/gps", likely=0)
    words = r"^/imu of type lab/Imu \(300 rows\) cannot be decoded: no definition"
    refused(UsageError, f"{words}$", lambda: chosen([lost, other], "/imu"))
    refused(UsageError, f"{words}; no table .*channels='/imu'", lambda: chosen([lost, other]))
    assert chosen([lost, stream("/fog")]) == "/fog"

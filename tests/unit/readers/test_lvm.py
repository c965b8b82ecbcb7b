"""LabVIEW measurement files: headers, segments, separators, and what is incomplete."""

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import refused

import allanite as al

GYRO = np.random.default_rng(6).normal(size=(400, 2))


def head(times, mark="Tab", decimal="."):
    sign = "," if mark == "Comma" else "\t"
    about = f"Writer_Version{sign}2\nSeparator{sign}{mark}\nDecimal_Separator{sign}{decimal}\nX_Columns{sign}{times}\n"
    return f"LabVIEW Measurement\t\n{about}Operator{sign}N. N.\n***End_of_Header***\t\n\t\n"


def segment(names, rows, *, second=5.25, step=0.01, units=("deg/s", "deg/s"), sign="\t"):
    two = {
        "Samples": [len(rows)] * 2, "Date": ["2026/01/02"] * 2, "Time": [f"03:04:{second:09.6f}00000"] * 2,
        "Y_Unit_Label": units, "X_Dimension": ["Time"] * 2, "X0": ["0.0E+0"] * 2, "Delta_X": [f"{step:.6f}"] * 2,
    }  # fmt: skip
    about = f"Channels{sign}2\n" + "".join(sign.join(map(str, (k, *v))) + "\n" for k, v in two.items())
    return about + "***End_of_Header***\n" + sign.join(names) + "\n" + "\n".join(rows) + "\n"


def rows(values, sign="\t", times=True):
    return [sign.join((f"{k * 0.01:.6f}" if times else "", *map(repr, v))) for k, v in enumerate(values.tolist())]


NAMES = ("X_Value", "gx", "gy")


def test_one_segment_with_times_and_a_comment(write):
    lines = rows(GYRO)
    lines[3] += "\ton the table"
    recording = al.read(write(head("One") + segment((*NAMES, "Comment"), lines), "a.lvm"))
    assert (recording.channels, recording[0].unit, recording[0].size) == (("gx", "gy"), "deg/s", 400)
    assert recording[0].rate == pytest.approx(100.0)
    assert np.array_equal(np.column_stack([r.values for r in recording]), GYRO)
    # without times the step of the header counts
    recording = al.read(write(head("No") + segment(NAMES, rows(GYRO, times=False), step=0.004), "a.lvm"))
    assert recording[0].rate == 250.0
    assert "rate 250.0 Hz from Delta_X in the header" in recording.notes
    assert np.array_equal(recording[1].values, GYRO[:, 1])
    # a time for each channel, commas and decimal commas
    four = np.column_stack((GYRO[:, 0], np.arange(400) * 0.01, GYRO[:, 1]))
    text = head("Multi") + segment(("X_Value", "gx", "X_Value", "gy"), rows(four))
    assert np.array_equal(al.read(write(text, "a.lvm"))["gy"].values, GYRO[:, 1])
    text = head("One", "Comma") + segment(NAMES, rows(GYRO, ","), sign=",")
    assert np.array_equal(al.read(write(text, "a.lvm"))["gx"].values, GYRO[:, 0])
    text = head("One", decimal=",") + segment(NAMES, rows(GYRO))
    recording = al.read(write(text.replace(".", ","), "a.lvm"))
    assert recording[0].rate == pytest.approx(100.0)
    assert np.array_equal(recording["gx"].values, GYRO[:, 0])
    # segments are joined by their times
    parts = [segment(NAMES, rows(GYRO[at : at + 200]), second=s) + "\n" for at, s in ((0, 5.25), (200, 7.75))]
    for times, text in (("One", "".join(parts)), ("No", "".join(parts))):
        recording = al.read(write(head(times) + text, "a.lvm"))
        assert (recording[0].rate, recording[0].size) == (pytest.approx(100.0), 450)
        assert np.isnan(recording[0].values[200:250]).all()
        assert np.array_equal(recording[1].values[250:], GYRO[200:, 1])


def test_incomplete_files_and_units_that_are_missing(write):
    whole = head("One") + segment(NAMES, rows(GYRO), units=("", ""))
    refused(al.UsageError, "'gx', 'gy': the unit is unknown", lambda: al.read(write(whole, "a.lvm")))
    for text, words in (
        (whole[:200], "the end of a header, .* is missing"),
        (whole[: whole.index("X_Value\t")], "should name 2 channels"),
        (whole[: whole.index("0.000000\t")], "no rows of numbers"),
        (whole.replace("Channels\t2", "Channels\tx"), "damaged"),
        (whole.replace("\n0.020000\t", "\n0.0x20000\t"), r"line 21.*'0\.0x20000' is not a number"),
    ):
        ends(run("info", write(text, "a.lvm"), "--unit", "deg/s"), 3)
        with pytest.raises(al.DataError, match=words):
            al.read(write(text, "a.lvm"), unit="deg/s")

"""The layout of a first screen."""

from allanite.core.finding import Finding
from allanite.reporting.first import Axes, First, Quantity, Remark, told_of
from allanite.reporting.screen import render

REMARKS = [Remark.of("", f"remark {i}") for i in range(9)]


def rows(channels):
    found = [Quantity("found", f"N{i}", "s", ["1"] * channels) for i in range(9)]
    return [*found, Quantity("a limit", "K", "s", ["< 2"] * channels, rank=1)]


def test_many_rows_become_a_line_for_each_channel_and_none_is_left_out():
    parts = [Axes([f"channel {i}{j}" for i in range(3)], rows(3)) for j in range(2)]
    shown = render(First("file", answer=parts, remarks=REMARKS))
    assert [line.split()[1] for line in shown.splitlines() if line.startswith("channel ")] == [
        "N0", "00", "10", "20", "N0", "01", "11", "21",
    ]  # fmt: skip
    assert "more line" not in shown
    assert "< 2" not in shown
    assert shown.count("remark ") > 2


def test_of_channels_with_long_names_the_first_is_named_and_what_is_wrong_is_told():
    names = [f"accelerometer_m_s2[{i}]" for i in range(4)]
    found = Finding("gaps", "2 of 9 samples are missing in 1 gap", "", "the rest: --from 1 --until 2")
    (about,) = told_of([(name, found) for name in names], 6)
    assert about.about == "accelerometer_m_s2[0] and 3 more"
    shown = render(First("", remarks=[about], after=[]), width=75).splitlines()
    assert shown == [
        "accelerometer_m_s2[0] and 3 more: 2 of 9 samples are missing in 1 gap. Try",
        "  --from 1 --until 2",
    ]


def test_where_columns_are_too_many_the_grade_is_kept():
    rows = [Quantity("found", symbol, "deg/h", ["1.2 ± 10 %, weak"] * 6) for symbol in "NBKG"]
    rows += [Quantity("in-run bias stability", "", "deg/h", ["323 at 10.8 s"] * 6, short="in-run")]
    rows += [Quantity("model fit", "", "", ["fits, p 0.5"] * 6, short="model")]
    shown = render(First("file", answer=[Axes([f"channel {i}" for i in range(6)], rows)], after=[]))
    assert shown.count("fits, p 0.5") == 6
    assert "in-run" not in shown


def test_lines_of_channels_beyond_the_screen_are_counted():
    lines = render(First("file", answer=[Axes([f"c{i}" for i in range(40)], rows(40))])).splitlines()
    (more,) = [line for line in lines if "more line" in line]
    assert sum(line.startswith("c") for line in lines) - 1 + int(more.split()[1]) == 40

"""The layout of a first screen."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.rows import rows

import allanite as al
from allanite.core.validity import Finding
from allanite.reporting import first_screen
from allanite.reporting.first import ChannelRow, Channels, First, Remark, Section, condensed, told_of
from allanite.reporting.screen import COLUMNS, LINES, render
from allanite.reporting.sheet import Column, Face, Note, Sheet, Table
from allanite.reporting.views.jobs import doubts
from allanite.study.modelled import PlanSettings, SelfCheckSettings, StateSpaceSettings, run_model_job


def quantities(channels):
    found = [ChannelRow("found", f"N{i}", "s", ["1"] * channels) for i in range(9)]
    return [*found, ChannelRow("a limit", "K", "s", ["< 2"] * channels, rank=1)]


def test_tables_of_many_and_of_wide_channels():
    parts = [Channels([f"channel {i}{j}" for i in range(3)], quantities(3)) for j in range(2)]
    shown = render(First("file", answer=parts, remarks=[Remark.of("", f"remark {i}") for i in range(9)]))
    begun = [line.split()[1] for line in shown.splitlines() if line.startswith("channel ")]
    assert begun == ["N0", "00", "10", "20", "N0", "01", "11", "21"]
    assert "more line" not in shown
    assert "< 2" not in shown
    assert shown.count("remark ") > 2
    # where columns are too many the grade is kept
    rows = [ChannelRow("found", symbol, "deg/h", ["1.2 ± 10 %, weak"] * 6) for symbol in "NBKG"]
    rows += [ChannelRow("in-run bias stability", "", "deg/h", ["323 at 10.8 s"] * 6, short="in-run")]
    rows += [ChannelRow("model fit", "", "", ["fits, p 0.5"] * 6, short="model")]
    shown = render(First("file", answer=[Channels([f"channel {i}" for i in range(6)], rows)], after=[]))
    assert shown.count("fits, p 0.5") == 6
    assert "in-run" not in shown
    assert "…" in shown.splitlines()[2]  # of the heading
    # lines of channels beyond the screen are counted
    lines = render(First("file", answer=[Channels([f"c{i}" for i in range(40)], quantities(40))])).splitlines()
    (more,) = [line for line in lines if "more line" in line]
    assert sum(line.startswith("c") for line in lines) - 1 + int(more.split()[1]) == 40
    # titles give way before a channel does
    cell = "0.2895 -> 0.2990  no change (+1.3 %)"
    rows = [ChannelRow("white noise of the angle", "N", "arcsec*sqrt(s)", [cell] * 2)]
    shown = render(First("file", answer=[Channels(["angle x", "angle y"], rows, "measured angle")]))
    assert shown.count(cell) == 2
    # channels whose cells are wide stand below each other
    cells = [f"{i} -> {i}.5  no change (-0.57 %), of two units" for i in range(2)]
    answer = Channels(["gx", "gy"], [ChannelRow("quantity", symbol, "deg/h", cells) for symbol in "NBK"])
    shown = render(First("file", answer=[answer]))
    assert [shown.count(cell) for cell in cells] == [3, 3]


def test_remarks_of_one_kind_share_a_line():
    names = [f"accelerometer_m_s2[{i}]" for i in range(4)]
    found = Finding("gaps", "2 of 9 samples are missing in 1 gap", "", "the rest: --from 1 --until 2")
    (about,) = told_of([(name, found) for name in names], 6)
    assert about.about == "accelerometer_m_s2[0] and 3 more"
    shown = render(First("", remarks=[about], after=[]), width=75).splitlines()
    told = "accelerometer_m_s2[0] and 3 more: 2 of 9 samples are missing in 1 gap. Try"
    assert shown == [told, "  --from 1 --until 2"]
    # warnings of sheets are remarks and those of one kind share a line
    grades = [Note(f"p = 0.{i}", "alert") for i in range(3)]
    sheets = [Sheet(name, (), (note, Note("short", "warning"))) for name, note in zip("abc", grades, strict=True)]
    first = condensed(Face("title", "brand", [*sheets, Sheet("d", (), (Note("as of d", "warning"),))]))
    grave = [(name, note.text, True) for name, note in zip("abc", grades, strict=True)]
    told = [(r.about, r.clauses[0], r.grave) for r in first.remarks]
    assert told == [*grave, ("a, b, c", "short", False), ("d", "as of d", False)]


def made(rng):
    """A first screen of any size whose lines have words of their own."""
    tokens = (f"t{i}t" for i in range(10_000))

    def sentence():
        return "; ".join(" ".join(next(tokens) for _ in range(rng.integers(1, 30))) for _ in range(rng.integers(1, 4)))

    def section(i, heads, wide):
        said = [sentence() for _ in range(rng.integers(0, 3))] if rng.random() < 0.4 else []
        cells = [[next(tokens) for _ in range(wide)] for _ in range(rng.integers(1, 13))]
        table = Table([Column(f"{heads}{j}") for j in range(wide)], cells)
        return Section(f"channel{i}", said, [table] if rng.random() < 0.9 or not said else [])

    wide = int(rng.integers(1, 7))
    sections = [section(i, "head" if rng.random() < 0.7 else f"head{i}", wide) for i in range(rng.integers(1, 25))]
    remarks = [
        Remark.of(f"channel{i}", sentence(), grave=bool(rng.random() < 0.3), name=str(i))
        for i in range(rng.integers(0, 13))
    ]
    notes = [sentence() for _ in range(rng.integers(0, 4))]
    return First("file", "verdict", sections, sorted(remarks, key=lambda remark: not remark.grave), (), notes)


def test_nothing_is_lost_in_silence_whatever_the_rows_and_the_room():
    for seed in range(60):
        rng = np.random.default_rng(seed)
        first, width = made(rng), int(rng.integers(60, COLUMNS + 1))
        shown = render(first, width=width)
        lines = shown.splitlines()
        assert 0 < len(lines) <= LINES
        assert max(map(len, lines)) <= width
        rows = [row for section in first.answer for table in section.tables for row in table.rows]
        counted, more = (re.search(rf"and (\d+) more {what}|$", shown)[1] for what in ("lines?", "notes?: "))
        assert sum(not re.search(rf"\b{row[0]}\b", shown) for row in rows) <= int(counted or 0), seed
        told = sum(f"{remark.about}: " in shown for remark in first.remarks)
        assert told + int(more or 0) == len(first.remarks), seed
        assert "…." not in shown


@rows("command", ["", "--from 12.5 --until 9000", "allanite deviation FILE"])
def test_a_remark_is_cut_behind_clauses_only(command):
    rng = np.random.default_rng(len(command))
    for _ in range(60):
        clauses = [
            " ".join([*("word" * int(n) for n in rng.integers(1, 3, rng.integers(1, 25))), f"{rng.random():.3g}"])
            + (" (an aside of 12 %)" if rng.random() < 0.3 else "")
            for _ in range(rng.integers(1, 5))
        ]
        width = int(rng.integers(60, COLUMNS + 1))
        shown = render(First("", remarks=[Remark("gx", clauses, command)], after=[]), width=width)
        text, _, after = " ".join(line.strip() for line in shown.splitlines()).partition(". Try ")
        assert after == command
        whole = f"gx: {'; '.join(clauses)}"
        ends = {len(whole), *(found.start() for found in re.finditer(r";| \((?=[^)]*\)(?:$|;))", whole))}
        cut = text.removesuffix(".")
        assert whole.startswith(cut)
        assert len(cut) in ends
        assert command or text == whole or text.endswith(".")


@rows("settings", [PlanSettings(), StateSpaceSettings(), SelfCheckSettings(records=2, samples=500)])
def test_recordings_of_many_channels_have_a_first_screen(settings):
    record = al.simulate(al.Model("N 0.1 deg/sqrt(h), K 30 deg/h/sqrt(h)"), 4000, 20.0, rng=np.random.default_rng(2))
    alone = run_model_job(al.Recording((record,)), settings, al.Recipe())
    for count in (6, 7, 12, 24):
        assert len(first_screen(replace(alone, channels=alone.channels * count)).splitlines()) <= LINES


@rows("unit, factor", [("deg/s", 3600 * 180 / np.pi), ("m/s^2", 1e6 / 9.80665)])
def test_the_in_run_minimum_is_that_of_the_curve_in_the_unit_that_is_named(unit, factor):
    noise = al.N(0.2, "deg/sqrt(h)") if unit != "m/s^2" else al.N(30, "ug/sqrt(Hz)")
    record = al.simulate(noise, 3000, 10.0, rng=np.random.default_rng(4), unit=unit)
    study = al.analyze(record)
    m = round(study[0].readings.minimum.tau * record.rate)
    curve = al.deviation(record, "oadev", m=(m,), noise=None)
    assert curve.unit in ("rad/s", "m/s^2")
    least = float(curve.deviation[0]) * factor
    named, shown = re.search(r"in-run bias stability +(\S+) +([\d.]+) \(", first_screen(study)).groups()
    assert named == ("µg" if unit == "m/s^2" else "°/h")
    assert float(shown) == pytest.approx(least, rel=2e-2)  # two digits where the interval is wide


@rows("name, blamed", [("gaps", False), ("level", True)])
def test_a_gap_is_no_cause_of_a_misfit(name, blamed):
    finding = Finding(name, "the finding", remedy="try prepare.trim(recording, 1, 2)", fatal=name == "level")
    statement = SimpleNamespace(points=("the reason of the fit",), head="")
    noise = SimpleNamespace(explained=False, residuals=None, fit=SimpleNamespace(findings=()), statement=statement)
    quality = SimpleNamespace(warnings=(finding,))
    channel = SimpleNamespace(record=SimpleNamespace(name="gx"), refusal="", noise=noise, quality=quality)
    (remark,) = doubts([channel])
    assert str(remark.clauses[0]) == ("the finding" if blamed else "the reason of the fit")

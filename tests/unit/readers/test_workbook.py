"""Excel workbooks: sheets are chosen and read like CSV files, and claims of a workbook are not believed."""

import datetime
import zipfile

import numpy as np
import pytest
from tests.commands import ends, run
from tests.rows import refused, rows

import allanite as al

openpyxl = pytest.importorskip("openpyxl")
GYRO = np.random.default_rng(9).normal(size=(300, 2))
START = datetime.datetime(2026, 1, 2, 3, 4, 5)


def workbook(path, **sheets):
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, table in sheets.items():
        sheet = book.create_sheet(name.replace("_", " "))
        for row in table:
            sheet.append(row)
    book.save(path)
    return path


def timed(count=300):
    rows = [["time [s]", "gx [deg/s]", "gy [deg/s]", "T [degC]"]]
    return rows + [[i * 0.01, *GYRO[i].tolist(), 25.5] for i in range(count)]


def test_the_only_sheet_with_a_gyro_is_read_like_csv(tmp_path):
    above = [["Unit 5, on the table"], [], [None, "operator", "N. N."]]
    path = workbook(tmp_path / "a.xlsx", Notes=[["nothing"]], Run_1=above + timed(), Mean=[["mean", 3.5], ["std", 0.1]])
    recording = al.read(path)
    assert (recording.channels, recording[0].rate) == (("gx", "gy"), pytest.approx(100.0))
    assert np.allclose(recording[1].values, GYRO[:, 1], rtol=1e-15)  # written with 16 digits
    assert recording.others[0].unit == "degC"
    assert "samples of Run 1 (300 rows)" in recording.notes


def test_dates_empty_cells_and_units_in_a_row_of_their_own(tmp_path):
    rows = [["when", "gx", "gy", "remark"], [None, "deg/s", "deg/s", None]]
    rows += [[START + i * datetime.timedelta(milliseconds=20), *row, None] for i, row in enumerate(GYRO.tolist())]
    rows[9][1], rows[202][3] = None, "on"
    recording = al.read(workbook(tmp_path / "a.xlsx", Run=rows), time="when")
    assert (recording.channels, recording[0].rate) == (("gx", "gy"), pytest.approx(50.0))
    assert np.flatnonzero(np.isnan(recording[0].values)).tolist() == [7]
    assert np.allclose(recording[1].values, GYRO[:, 1], rtol=1e-15)  # written with 16 digits


@pytest.mark.slow("takes more than half a second")
def test_several_sheets_are_listed_and_chosen(tmp_path):
    path = workbook(tmp_path / "a.xlsx", Run_1=timed(), Run_2=timed(250))
    words = r"2 tables .*\(Run 1 \(300 rows\), Run 2 \(250 rows\)\).*channels='Run 1'"
    refused(al.UsageError, words, lambda: al.read(path))
    assert al.read(path, channels=["Run 2"])[0].size == 250
    assert al.read(path, channels=["Run 2/gy"]).channels == ("gy",)
    ends(run("info", path), 2, "--channels 'Run 1'")


def test_a_sheet_without_header_asks_for_rate_and_unit(tmp_path):
    path = workbook(tmp_path / "a.xlsx", Run=GYRO.tolist())
    refused(al.UsageError, r"sampling rate.*unit is unknown", lambda: al.read(path))
    assert al.read(path, rate=100, unit="deg/s")[0].size == 300
    # progress is told while sheets are read
    shares = []
    rows = [[k * 0.01, *GYRO[k % 300].tolist(), 25.5] for k in range(2500)]
    al.read(workbook(tmp_path / "a.xlsx", Run=timed(0) + rows), progress=shares.append)
    assert [share for share in shares if 0 < share < 1] == pytest.approx([1000 / 2501, 2000 / 2501])
    # workbooks without numbers and damaged ones
    refused(al.DataError, "no sheet", lambda: al.read(workbook(tmp_path / "a.xlsx", Notes=[["nothing"]])))
    whole = workbook(tmp_path / "a.xlsx", Run=timed()).read_bytes()
    for data in (whole[: len(whole) // 2], whole[:4] + bytes(500)):
        path.write_bytes(data)
        ends(run("info", path), 3, "the archive is incomplete")


def replaced(folder, sheet):
    space = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
    sheet = sheet.replace("<worksheet>", f'<worksheet xmlns="{space}">')
    whole = workbook(folder / "a.xlsx", Run=timed())
    with zipfile.ZipFile(whole) as old, zipfile.ZipFile(folder / "b.xlsx", "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            new.writestr(name, sheet if name == "xl/worksheets/sheet1.xml" else old.read(name))
    return folder / "b.xlsx"


@pytest.mark.slow("takes more than half a second")
@rows("sheet", [
    '<worksheet><sheetData><row r="99999999999"><c r="A1"><v>1</v></c></row></sheetData></worksheet>',
    '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa">'
    + "".join(f'<!ENTITY {b} "{("&" + a + ";") * 10}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True))
    + "]><worksheet><sheetData><row><c><v>&i;</v></c></row></sheetData></worksheet>",
    "<worksheet><sheetData><row><c><v>" + "1" * 60_000_000 + "</v></c></row></sheetData></worksheet>",
], ids=["row number", "entities", "a long cell"])  # fmt: skip
def test_bombs_are_refused(tmp_path, sheet):
    path = replaced(tmp_path, sheet)
    refused(al.DataError, "openpyxl failed|claims|no sheet", lambda: al.read(path, rate=1, unit="deg/s"))


def test_a_sheet_that_claims_to_be_larger_is_read(tmp_path):
    rows = "".join(f'<row r="{i}"><c r="A{i}"><v>{i * i % 101}.5</v></c></row>' for i in range(1, 900))
    sheet = f'<worksheet><dimension ref="A1:XFD1048576"/><sheetData>{rows}</sheetData></worksheet>'
    assert al.read(replaced(tmp_path, sheet), rate=1, unit="deg/s")[0].size == 899

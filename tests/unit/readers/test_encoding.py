"""Texts in UTF-8, GB18030, cp1251 and Latin-1, with units and names in Russian and Chinese."""

import numpy as np
import pytest
from tests.rows import refused, rows

from allanite.core.errors import DataError, UnitError
from allanite.core.units import unit_of
from allanite.readers import read
from allanite.readers.columns.encoding import in_utf8

NOISE = np.random.default_rng(1).standard_normal((300, 3)).round(4)


RUSSIAN = ["Оператор: Иванов", "Время, с;ДУС X, °/с;Угловая скорость Y [°/ч];Ускорение X, м/с²;Температура, °С"]
RUSSIAN_1251 = [RUSSIAN[0], RUSSIAN[1].replace("м/с²", "м/с2")]
CHINESE = ["操作员：张三", "时间(秒);陀螺X（度/秒）;角速度Y(度/小时);加速度X(米/秒^2);温度(度)"]


@rows("lines, encoding, note", [
    (RUSSIAN, "utf-8", ""), (RUSSIAN, "utf-8-sig", ""), (RUSSIAN, "utf-16", ""),
    (RUSSIAN_1251, "cp1251", "read as cp1251"), (CHINESE, "utf-8", ""), (CHINESE, "gbk", "read as GB18030"),
    (CHINESE, "gb18030", "read as GB18030"),
])  # fmt: skip
@rows("comma", [False, True])
def test_names_and_units(write, lines, encoding, note, comma):
    rows = "\n".join(";".join([f"{i / 100:.2f}", *map(str, row), "25.5"]) for i, row in enumerate(NOISE))
    text = "\n".join([*lines, rows.replace(".", ",") if comma else rows, ""])
    recording = read(write(text.encode(encoding)))
    wanted = ("deg/s", "deg/h", "m/s^2")
    assert [unit_of(record.unit) for record in recording] == [unit_of(unit) for unit in wanted]
    assert [record.rate for record in recording] == [pytest.approx(100)] * 3
    assert all(np.array_equal(record.values, NOISE[:, i]) for i, record in enumerate(recording))
    assert any("not UTF-8" in said for said in recording.notes) == bool(note)
    assert note in " ".join(recording.notes)
    assert any("not an inertial signal by its name" in said for said in recording.notes)


@rows("text, encoding, name", [
    ("gx [°/s]", "latin-1", "Latin-1"), ("ax [µg]", "latin-1", "Latin-1"), ("m/s²", "latin-1", "Latin-1"),
    ("Prüfstand Größe;gx [°/s]", "latin-1", "Latin-1"), ("Température", "latin-1", "Latin-1"),
    ("mesurée à 100 Hz – l’été", "cp1252", "Latin-1"), ("mesure à 100", "latin-1", "Latin-1"),
    ("gx [°/с]", "cp1251", "cp1251"), ("gx [°/ч]", "cp1251", "cp1251"), ("ax [мкg];ay [м/с2]", "cp1251", "cp1251"),
    ("ВРЕМЯ;ДУС", "cp1251", "cp1251"), ("№;Скорость", "cp1251", "cp1251"), ("стоп", "cp1251", "cp1251"),
    ("t, с;gx", "cp1251", "cp1251"), ("gx[度/秒],gy[度/秒]", "gbk", "GB18030"), ("测试人员：张三", "gbk", "GB18030"),
    ("ωx(°/s)", "gbk", "GB18030"),
])  # fmt: skip
def test_each_encoding_is_told_from_the_others(text, encoding, name):
    data, (note,) = in_utf8(text.encode(encoding))
    assert data.decode() == text
    assert note.endswith(name)


@rows("data, words", [
    ("ПУСК".encode("cp1251"), "may be GB18030 or cp1251.*iconv"),
    (b"gx \x81\x01\xff\xfe\x98", "neither GB18030, cp1251 nor Latin-1.*iconv"),
    ("时间(秒)".encode("gbk") + b"\n1\n\xff\xff\n", "neither.*iconv"),
    ("时间(秒),陀螺X（度/秒）\n".encode("gbk") * 8000 + b"\xff\xff\n", "like GB18030 text but is damaged in line 8001"),
])  # fmt: skip
def test_what_cannot_be_decided_is_refused_with_the_cure(data, words):
    refused(DataError, words, lambda: in_utf8(data))


def test_utf8_is_tested_in_blocks_that_may_cut_a_letter():
    data = b"x" * ((1 << 20) - 1) + "°".encode() + b"y" * 10
    assert in_utf8(data) == (data, ())


@rows("unit, same", [
    ("°/с", "deg/s"), ("°/ч", "deg/h"), ("°/час", "deg/h"), ("град/с", "deg/s"), ("рад/с", "rad/s"),
    ("м/с²", "m/s^2"), ("м/с2", "m/s^2"), ("мg", "mg"), ("мкg", "ug"), ("°/√ч", "deg/sqrt(h)"), ("угл.с", "arcsec"),
    ("°/ч/√Гц", "deg/h/sqrt(Hz)"), ("度/秒", "deg/s"), ("度/小时", "deg/h"), ("弧度/秒", "rad/s"), ("度每秒", "deg/s"),
    ("米/秒²", "m/s^2"), ("毫g", "mg"), ("微g", "ug"), ("度/√小时", "deg/sqrt(h)"), ("℃", "degC"), ("°С", "degC"),
    ("мс", "ms"), ("毫秒", "ms"),
])  # fmt: skip
def test_units_in_russian_and_chinese(unit, same):
    assert unit_of(unit) == unit_of(same)


@rows("unit", ["мг", "мкг", "г", "千克", "сч", "курсор"])
def test_other_words_are_no_units(unit):
    refused(UnitError, unit, lambda: unit_of(unit))

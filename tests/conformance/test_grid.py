"""The grid by which answers are judged: its records, its codes, its counts."""

from table import moved

import numpy as np
import scipy.stats
from tests.rows import rows

import allanite as al
import grid
from shapes import DISTURBANCES, SENSORS, record_of


def test_every_cell_has_a_record_and_its_truth():
    for (i, sensor), disturbance in zip(enumerate(SENSORS), list(DISTURBANCES)[:12], strict=True):
        for n in (4096, 5000):
            record, truth = record_of(sensor, disturbance, n, np.random.default_rng(i))
            assert len(record) == n
            assert set(truth) == set(grid.TERMS)
            assert truth["N"] is None or truth["N"] >= SENSORS[sensor]["N"]


def test_what_is_said_of_a_term():
    fit = al.identify(record_of("N", "none", 4096, np.random.default_rng(1))[0])
    size = np.degrees(fit["N"].value)
    low, high = np.degrees(fit["N"].interval(0.95))
    for symbol, true, codes in (
        ("N", size, "in upper"), ("N", 1.01 * high, "edge"), ("N", 0.99 * low, "edge upper"), ("N", 3 * size, "wrong"),
        ("N", 0.0, "false"), ("N", None, "either"), ("K", 0.0, "none"), ("K", 1e-9, "low upper"), ("K", 1.0, "miss"),
    ):  # fmt: skip
        assert grid.codes_of(fit, symbol, true) == codes.split(), (symbol, true)


def test_counts_are_written_and_read(tmp_path, monkeypatch):
    monkeypatch.setattr(grid, "COUNTS", tmp_path / "grid.csv")
    cells = grid.read_counts("")
    for cell in cells[:3]:
        cell.add(*grid.answer((*cell.name[:2], 1024, 0)))
    cells[0].add("misleading", {"N": ["in", "upper"], "Q": ["none"]}, ["lines", "slope"])
    grid.write_counts(cells, "1234567")
    assert grid.read_counts("") == cells
    page = "\n".join(grid.tables(cells))
    assert page.count("\n## ") == 4
    assert "| all | 4 |" in page
    monkeypatch.setattr(grid, "unchanged", lambda since, rooms: False)
    assert sum(cell.records for cell in grid.read_counts("7654321")) == 0


def test_a_named_cell_has_a_cause_or_a_chance():
    cells = [grid.Cell(("N", name, 4096)) for name in ("step", "none", "gaps", "hum")]
    for cell, code in zip(cells, ({"K false": 7}, {"Q false": 7}, {"Q false": 6}, {"N wrong": 7}), strict=True):
        cell.records, cell.verdicts["wrong"] = 100, code.get("N wrong", 0)
        cell.codes.update(code)
    by_cause, *by_chance = grid.named_cells(cells)
    assert by_cause[-2:] == ("K false 7", "smaller than can be told from slow noise")
    for row, words, rate in zip(by_chance, ("Q false 7", "N wrong 7"), grid.RATES, strict=True):
        assert row[-2:] == (words, f"{words[0]}: by chance {100 * scipy.stats.binom.sf(6, 100, rate):.2g} %")


@rows("hits, of, others, among",
      [(0, 100, 11, 100), (0, 100, 14, 100), (50, 100, 25, 100), (9, 90, 4, 8), (0, 5, 0, 9)])  # fmt: skip
def test_a_share_has_moved_beyond_its_error(hits, of, others, among):
    p = scipy.stats.fisher_exact([[hits, of - hits], [others, among - others]]).pvalue
    assert moved(hits, of, others, among) == (p < 1e-4)

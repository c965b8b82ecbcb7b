"""The simulator that judges the package has the spectra of textbooks."""

from tests.rows import rows

from judge import TEXTBOOK, TOLERANCE, ratios


@rows("name", list(TEXTBOOK))
def test_its_spectra_are_those_of_textbooks(name):
    assert all(abs(ratio - 1) < TOLERANCE for ratio in ratios(name))

"""The tests of the sample, as a package has them: what it adds keeps what is demanded of every row."""

from pathlib import Path

from allanite_sample import tones

from allanite.cli import VERBS
from allanite.exporting.exports import EXPORTS
from allanite.planning.datasheets import DATASHEETS
from allanite.statistics import STATISTICS
from allanite.terms import TERMS
from allanite.testing import check_data_sheet, check_reader, check_statistic, check_target, check_term, check_verb

FILE = str(Path(__file__).with_name("example.tones"))


def test_the_format():
    check_reader(tones, FILE)


def test_the_statistic():
    check_statistic(STATISTICS["fdev"])


def test_the_noise_term():
    check_term(TERMS["RR"])


def test_the_target():
    check_target(EXPORTS["pilot"])


def test_the_data_sheet():
    check_data_sheet(DATASHEETS["SG-1"])


def test_the_verb():
    assert check_verb(VERBS["extent"], FILE)["type"] == "Extents"

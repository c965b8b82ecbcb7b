"""Phrases that the page begins with a capital letter, and the words of every status and sensor."""

import pickle

from allanite.core.estimate import STATUSES
from allanite.core.units import SIGNALS
from allanite.phrases.phrase import say
from allanite.reporting import words


class Upside:
    """A catalogue in which every template is written backwards, but for its fields."""

    def gettext(self, message):
        return message if "{" in message else message[::-1]

    def ngettext(self, one, many, count):
        return one if count == 1 else many


def test_phrases_begin_with_a_capital_letter_and_all_have_words():
    said = words.capital(say("{term} ({symbol})", term=say("rate ramp"), symbol="R"))
    assert said == "Rate ramp (R)"
    assert said.within(Upside()) == "Pmar etar (R)"
    assert pickle.loads(pickle.dumps(said)).within(Upside()) == "Pmar etar (R)"
    assert all(row.name == status and row.meaning for status, row in STATUSES.items())
    assert all(signal.a_sensor.endswith(signal.sensor) for signal in SIGNALS)

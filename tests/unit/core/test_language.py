"""Phrases are English text, and can be said in another language."""

import copy
import gettext
import json
import pickle

from allanite.core.errors import DataError
from allanite.core.estimate import STATUSES
from allanite.core.units import SIGNALS
from allanite.phrases.phrase import Phrase, join, say, say_count, translate
from allanite.reporting import words

WORDS = {"minimum": "Minimum", "{title} at {tau:.3g} s": "{title} bei {tau:.3g} s", "{count} gaps": "{count} Lücken"}


class German(gettext.NullTranslations):
    """A catalogue of a few templates."""

    def gettext(self, message: str) -> str:
        return WORDS.get(message, message)

    def ngettext(self, one: str, many: str, count: int) -> str:
        return "{count} Lücke" if count == 1 else WORDS.get(many, many)


def test_a_phrase_is_english_text_and_is_said_in_another_language():
    said = say("{title} at {tau:.3g} s", title=say("minimum"), tau=12.3456)
    assert (said, json.dumps(said), f"{said}!") == ("minimum at 12.3 s", '"minimum at 12.3 s"', "minimum at 12.3 s!")
    assert say("{title} at {tau:.3g} s", title=say("minimum"), tau=12.3456).within(German()) == "Minimum bei 12.3 s"
    assert say("{title} at {tau:.3g} s", title="minimum", tau=1).within(German()) == "minimum bei 1 s"
    listed = join(" {}, ", [say("minimum"), "minimum", say_count(2, "{count} gap", "{count} gaps")])
    assert (listed.within(German()), join(", ", [])) == ("Minimum {}, minimum {}, 2 Lücken", "")
    said = str(DataError(say("minimum")))
    assert isinstance(said, Phrase)
    assert (translate(said, German()), translate(say("no {what}", what="gap"), German())) == ("Minimum", "no gap")
    assert (translate(3.5, German()), say("a {brace}")) == (3.5, "a {brace}")


def test_all_statuses_and_signals_have_words():
    assert all(row.name == status and row.meaning for status, row in STATUSES.items())
    assert all(signal.a_sensor.endswith(signal.sensor) for signal in SIGNALS)


def test_nouns_agree_with_the_number():
    shown = [say_count(count, "{count} gap", "{count} gaps").within(German()) for count in (1, 5, 0)]
    assert shown == ["1 Lücke", "5 Lücken", "0 Lücken"]


def test_a_phrase_with_a_capital_letter_and_its_copies_keep_the_template():
    said = words.capital(say("{title} at {tau:.3g} s", title=say("gap"), tau=12.3456))
    for kept in (said, copy.deepcopy(said), pickle.loads(pickle.dumps(said))):
        assert (kept, kept.within(German())) == ("Gap at 12.3 s", "Gap bei 12.3 s")

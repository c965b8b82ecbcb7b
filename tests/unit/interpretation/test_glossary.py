"""Words that `explain` knows: every term, statistic, status and word of the glossary, in ten lines."""

import re

from tests import ROOT
from tests.verbs import run

from allanite.core.estimate import STATUSES
from allanite.interpretation.glossary import named_words, words
from allanite.statistics import STATISTICS
from allanite.terms import TERMS


def test_every_word_of_the_program_and_of_the_glossary_is_known():
    page = (ROOT / "docs" / "glossary.md").read_text("utf-8")
    blocks = re.findall(r"```\{glossary\}\n(.*?)```", page, re.DOTALL)
    glossary = [line for block in blocks for line in block.splitlines() if re.match(r"\S", line)]
    assert len(glossary) > 60
    others = "reservation", "cover", "worst axis", "approximate", "band", "inflate", "ARW", "VRW", "BI", "unexplained"
    for name in (*TERMS, *STATISTICS, *STATUSES, *others, *glossary):
        spelled = re.sub("[-_ ]", "-", name.upper())
        assert run(f'explain "{spelled}"').stdout, name


def test_a_word_is_told_in_ten_lines_with_a_formula_an_example_and_names_that_are_known():
    for word in words().values():
        assert len(run(f'explain "{word.name}"').stdout.splitlines()) <= 10 or set(word.synonyms) & {*STATISTICS}
        assert word.formula, word.name
        assert word.example, word.name
        for name in word.see:
            assert run(f'explain "{name}"').stdout
    names = [name.lower() for word in words().values() for name in {word.name.lower(), *map(str.lower, word.synonyms)}]
    assert len(names) == len(set(names)) >= len(named_words()) - 10

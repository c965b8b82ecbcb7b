"""An analysis of a recording is made once, whichever module or command asks for it."""

import os

import pytest

from allanite.phrases.phrase import command_line
from allanite.study import analysis

MADE = {}
"""The studies of this process by their file and recipe."""


@pytest.fixture(scope="module")
def analyzed_once():
    """Commands and functions share the study of a file with the same recipe, whose remedies name options."""
    usual = analysis.analyzed

    def shared(source, recipe, progress=None):
        key = (os.fspath(source), str(recipe.to_dict()))
        if key not in MADE:
            with command_line():
                MADE[key] = usual(source, recipe, progress)
        return MADE[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(analysis, "analyzed", shared)
        yield

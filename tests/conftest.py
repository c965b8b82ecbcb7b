"""Where real recordings and published tables are, for the tests that use them."""

import os
from pathlib import Path

import hypothesis
import pytest

from tests import examples

# a machine with other work to do is no failure
hypothesis.settings.register_profile("unhurried", deadline=None, max_examples=examples(100))
hypothesis.settings.load_profile("unhurried")

BESIDE = Path(__file__).resolve().parents[2] / "shared"


def _folder(variable, name, needed):
    folder = Path(os.environ.get(variable, BESIDE / name))
    if not (folder / needed).is_file():
        pytest.skip(f"no {name} in {folder}; set {variable} to the folder that holds {needed}")
    return folder


@pytest.fixture(scope="session")
def recordings():
    """Folder of real recordings: ALLANITE_RECORDINGS, or beside the project."""
    return _folder("ALLANITE_RECORDINGS", "recordings", "psins_lasergyro.imu")


@pytest.fixture(scope="session")
def reference():
    """Folder of published reference values: ALLANITE_REFERENCE, or beside the project."""
    return _folder("ALLANITE_REFERENCE", "reference", "INDEX.md")

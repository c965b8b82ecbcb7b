"""Files of the verbs, which several stories use."""

import pytest
from tests.verbs import furnish


@pytest.fixture(scope="session")
def furnished(tmp_path_factory):
    """The folder of the files that the rows of the verbs name."""
    folder = tmp_path_factory.mktemp("desk")
    furnish(folder)
    return folder

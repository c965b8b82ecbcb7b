"""What the tests of the server share: its folder, and a client that came in by the link of the module."""

import pytest

from .served import Client


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(scope="module")
def client(link):
    with Client(link) as client:
        yield client

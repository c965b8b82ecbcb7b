"""What the tests of the page share: one server and one browser a session, and a client of the server of a module."""

import importlib.util
import os

import numpy as np
import pytest

from .browsing import CHROMIUM, PATIENCE, written
from .served import Client, served


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(scope="module")
def client(link):
    with Client(link) as client:
        yield client


@pytest.fixture(scope="session")
def address(tmp_path_factory):
    """The link that opens the page, once."""
    with served(tmp_path_factory.mktemp("cache"), waiting=True) as (_, link):
        yield link


@pytest.fixture(scope="session")
def browser():
    api = importlib.util.find_spec("playwright") and importlib.import_module("playwright.sync_api")
    if api is None or CHROMIUM is None:
        words = "the page in a browser was not tried: Playwright or Chromium is not installed"
        pytest.fail(words) if os.environ.get("ALLANITE_CI") == "1" else pytest.skip(words)
    with api.sync_playwright() as play:
        one = play.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield one
        one.close()


@pytest.fixture(scope="session")
def context(browser, address):
    """A browser that has come in by the link; what it asks of other hosts is refused and noted."""
    one = browser.new_context(viewport={"width": 1280, "height": 900}, accept_downloads=True)
    one.set_default_timeout(PATIENCE)
    one.outside = []
    one.broken = []
    own = ("http://127.0.0.1:", "data:", "blob:")
    one.on("request", lambda request: None if request.url.startswith(own) else one.outside.append(request.url))
    one.on("weberror", lambda error: one.broken.append(str(error.error)))
    first = one.new_page()
    first.goto(address)
    first.wait_for_selector("body[data-ready=true]")
    one.address = first.url.partition("#")[0]
    one.secret = first.evaluate("localStorage.getItem('secret')")
    first.close()
    yield one
    one.close()


@pytest.fixture
def page(context):
    """The page with nothing in it."""
    own = {"Origin": context.address.rstrip("/"), "Authorization": f"Bearer {context.secret}"}
    made = context.request.post(f"{context.address}api/workspaces", headers=own)
    assert made.ok, made.text()
    one = context.new_page()
    one.add_init_script("for (const key of ['lang', 'workspace']) localStorage.removeItem(key)")
    one.goto(f"{context.address}#{made.json()['id']}")
    one.wait_for_selector("body[data-ready=true]")
    yield one
    one.close()
    assert context.outside == []
    assert context.broken == []


@pytest.fixture(scope="session")
def six(tmp_path_factory):
    """Six axes with units in the header."""
    values = np.random.default_rng(1).normal(size=(20_000, 6)) * [0.1, 0.1, 0.1, 1e-3, 1e-3, 1e-3]
    return written(tmp_path_factory.mktemp("data") / "six.csv", values)

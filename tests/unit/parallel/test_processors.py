"""Imports in a thread of their own while a file is read."""

import threading

import pytest

from allanite.parallel import processors
from allanite.parallel.processors import imported, importing, shared


def test_what_is_imported_is_there_afterwards_and_the_inner_waits_for_the_outer(monkeypatch):
    begun, order = threading.Event(), []

    def load(name):
        begun.wait()
        order.append((name, threading.current_thread() is threading.main_thread()))

    monkeypatch.setattr(processors, "import_module", load)
    with importing(["first"]), importing(["second", "third"]), importing([]):
        assert not order
        begun.set()
        imported()
        assert order == [("first", False), ("second", False), ("third", False)]


def test_of_two_processors_one_is_not_spare_while_modules_are_imported(monkeypatch):
    ended = threading.Event()
    monkeypatch.setattr(processors, "import_module", lambda _: ended.wait(60))
    for count, spare in ((1, False), (2, False), (3, True)):
        monkeypatch.setattr(processors, "processors", lambda count=count: count)
        ended.clear()
        with importing(["slow"]):
            assert processors.spare() == spare
            ended.set()
            imported()
            assert processors.spare()
        assert processors.spare()


def test_an_error_is_told():
    with pytest.raises(ModuleNotFoundError, match="no_such_module"), importing(["no_such_module"]):
        pass


def test_no_process_is_forked_before_the_imports_have_ended(monkeypatch):
    ended, asked = [], threading.Event()
    monkeypatch.setattr(processors, "import_module", lambda _: (asked.wait(60), ended.append(True)))
    monkeypatch.setattr(processors, "imported", lambda: (asked.set(), imported()))
    with importing(["slow"]):
        assert shared(lambda _: bool(ended), [0, 1, 2, 3], count=2) == [True] * 4

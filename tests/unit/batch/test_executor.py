"""Executors: every item has its result or its error, and a process that is killed takes nothing else with it."""

import multiprocessing

import pytest
from tests.rows import refused, rows
from tests.unit.batch.tasks import deadly, doubled, out_of_memory

import allanite as al
from allanite.batch.executor import Processes, Serial


@pytest.mark.slow("takes more than half a second")
@rows("executor", [Serial(), Processes(2)])
def test_an_error_belongs_to_its_item(executor):
    found = {done.item["x"]: done for done in executor.run(doubled, [{"x": x} for x in range(6)])}
    assert {x: done.result["y"] for x, done in found.items() if x != 3} == {0: 0, 1: 2, 2: 4, 4: 8, 5: 10}
    assert (found[3].result, found[3].error) == (None, "internal error (RuntimeError: three)")


def test_a_killed_process_is_replaced_and_its_item_tried_once_more(tmp_path):
    items = [{"x": x, "mark": str(tmp_path / x)} for x in ("a", "once", "always", "b", "c", "d")]
    found = {done.item["x"]: done for done in Processes(2).run(deadly, items)}
    assert {x for x, done in found.items() if done.result} == {"a", "b", "c", "d", "once"}
    assert found["always"].error.startswith("the process that analyzed it was killed by signal 9, twice")
    assert len(found) == len(items)
    assert not multiprocessing.active_children()


def test_processes_end_when_nobody_waits_for_the_rest():
    running = Processes(2).run(doubled, [{"x": x} for x in (0, 1, 2)])
    next(running)
    running.close()
    assert not multiprocessing.active_children()


def test_what_cannot_be_done_is_said():
    (done,) = Serial().run(out_of_memory, [{}])
    assert done.error == "not enough memory; use fewer workers, or read fewer channels"
    refused(al.UsageError, "at least 1, not 0", lambda: Processes(0))

"""Connections that ask for nothing are closed; those that ask are answered, however long it takes."""

import asyncio
from concurrent.futures import ThreadPoolExecutor
from itertools import count

import pytest
import uvicorn
from tests import ROOT
from tests.rows import rows
from uvicorn.server import ServerState

from allanite.web import routes
from allanite.web.routes import MAX_CONNECTIONS, TURN_TIMEOUT_S, PromptProtocol

WHOLE = b"GET / HTTP/1.1\r\nHost: a\r\n\r\n"


class Transport(asyncio.Transport):
    """A connection that may be closed."""

    closed = False

    def abort(self):
        self.closed = True

    def is_closing(self):
        return self.closed

    def write(self, data):
        pass

    def resume_reading(self):
        pass


async def prompt(scope, receive, send):
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"0")]})
    await send({"type": "http.response.body", "body": b""})


async def slow(scope, receive, send):
    await asyncio.Event().wait()


@pytest.fixture
def loop(monkeypatch):
    """A loop whose patience is over at its next turn."""
    monkeypatch.setattr(routes, "TURN_TIMEOUT_S", 0.0)
    loop = asyncio.new_event_loop()
    loop.connections = []  # as a server has them, or what answers is collected before it has answered
    yield loop
    while tasks := asyncio.all_tasks(loop):  # the first time, one that has not begun to answer waits to say so
        for task in tasks:
            task.cancel()
        turn(loop)
    loop.close()


def turn(loop):
    """Do what is due, in another thread: in this one a browser may hold a loop that runs."""
    with ThreadPoolExecutor(1) as thread:
        for _ in range(5):
            thread.submit(loop.run_until_complete, asyncio.sleep(0)).result()


def connected(loop, answer, state=None):
    """A connection to a server in this state."""
    made, transport = PromptProtocol(uvicorn.Config(answer), state or ServerState(), {}, _loop=loop), Transport()
    made.connection_made(transport)
    loop.connections.append(made)
    return made, transport


def test_a_client_has_ten_seconds_as_the_page_on_it_says():
    words = (ROOT / "docs" / "page.md").read_text("utf-8")
    assert f"within {TURN_TIMEOUT_S:.0f} s" in " ".join(words.split())


@rows("sent", [b"", b"GET / HT", WHOLE[:-2], b"POST / HTTP/1.1\r\nHost: a\r\nX: "])
def test_half_a_request_is_closed(loop, sent):
    made, transport = connected(loop, slow)
    first = made.late
    for piece in filter(None, (sent[:3], sent[3:])):
        made.data_received(piece)
    assert made.late is first  # what comes piece by piece does not put it off
    turn(loop)
    assert transport.closed


def test_whole_requests_have_all_the_time_and_half_ones_are_closed(loop):
    made, transport = connected(loop, slow)
    made.data_received(WHOLE[:9])
    made.data_received(WHOLE[9:])
    turn(loop)
    assert not transport.closed
    # half of the next request is closed too
    made, transport = connected(loop, prompt)
    made.data_received(WHOLE)
    turn(loop)
    assert made.cycle.response_complete
    assert not transport.closed
    made.data_received(WHOLE[:9])
    turn(loop)
    assert transport.closed


def test_an_answer_that_is_not_taken_is_broken_off(loop):
    made, transport = connected(loop, slow)
    made.data_received(WHOLE)
    made.pause_writing()
    made.resume_writing()
    turn(loop)
    assert not transport.closed
    made.pause_writing()
    turn(loop)
    assert transport.closed


def test_of_too_many_connections_the_oldest_that_waits_for_its_client_is_closed(loop):
    loop.time, state = count().__next__, ServerState()
    many = [connected(loop, slow, state) for _ in range(MAX_CONNECTIONS)]
    for made, _ in many[:3]:
        made.data_received(WHOLE)
    many[1][0].pause_writing()  # it takes no answer
    many += [connected(loop, slow, state) for _ in range(3)]
    assert [transport.closed for _, transport in many[:6]] == [False, True, False, True, True, False]
    assert sum(transport.closed for _, transport in many) == 3
    del loop.time

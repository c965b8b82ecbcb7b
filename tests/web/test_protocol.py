"""Connections that ask for nothing are closed; those that ask are answered, however long it takes."""

import asyncio

import pytest
import uvicorn
from tests.rows import rows
from uvicorn.server import ServerState

from allanite.web.protocol import PATIENCE, PromptProtocol

WHOLE = b"GET / HTTP/1.1\r\nHost: a\r\n\r\n"


class Loop:
    """Keeps what is to be called later, and does nothing by itself."""

    def __init__(self):
        self.calls, self.work = {}, []

    def call_later(self, delay, act):
        handle = Call(self, act)
        self.calls[handle] = delay
        return handle

    def create_task(self, work, **_):
        self.work.append(work)
        return asyncio.Future(loop=self)

    def get_debug(self):
        return False

    def pass_time(self):
        """What was to be called by now."""
        for handle in [handle for handle, delay in self.calls.items() if delay <= PATIENCE]:
            del self.calls[handle]
            handle.act()


class Call:
    """A call that is due."""

    def __init__(self, loop, act):
        self.loop, self.act = loop, act

    def cancel(self):
        self.loop.calls.pop(self, None)


class Transport(asyncio.Transport):
    """A connection that may be closed."""

    closed = False

    def close(self):
        self.closed = True

    def is_closing(self):
        return self.closed

    def write(self, data):
        pass

    def resume_reading(self):
        pass


async def answered(scope, receive, send):
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"0")]})
    await send({"type": "http.response.body", "body": b""})


@pytest.fixture
def connection():
    loop, transport = Loop(), Transport()
    protocol = PromptProtocol(uvicorn.Config(answered, ws="none"), ServerState(), {}, _loop=loop)
    protocol.connection_made(transport)
    yield protocol, loop, transport
    for work in loop.work:
        work.close()


@rows("sent", [b"", b"GET / HT", WHOLE[:-2], b"POST / HTTP/1.1\r\nHost: a\r\nX: "])
def test_half_a_request_is_closed(sent):
    loop, transport = Loop(), Transport()
    protocol = PromptProtocol(uvicorn.Config(answered, ws="none"), ServerState(), {}, _loop=loop)
    protocol.connection_made(transport)
    for k in range(len(sent)):  # bytes that come one by one do not put it off
        protocol.data_received(sent[k : k + 1])
    assert len(loop.calls) == 1
    loop.pass_time()
    assert transport.closed


def test_a_whole_request_has_all_the_time(connection):
    protocol, loop, transport = connection
    protocol.data_received(WHOLE[:9])
    protocol.data_received(WHOLE[9:])
    loop.pass_time()
    assert not transport.closed
    assert loop.calls == {}


def test_half_of_the_next_request_is_closed_too(connection):
    protocol, loop, transport = connection
    protocol.data_received(WHOLE)
    asyncio.run(loop.work.pop())
    assert protocol.cycle.response_complete
    protocol.data_received(WHOLE[:9])
    assert list(loop.calls.values()) == [PATIENCE]
    loop.pass_time()
    assert transport.closed

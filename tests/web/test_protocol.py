"""Connections that ask for nothing are closed; those that ask are answered, however long it takes."""

import asyncio

import pytest
import uvicorn
from tests.rows import rows
from uvicorn.server import ServerState

from allanite.web.protocol import MOST, PATIENCE, PromptProtocol

WHOLE = b"GET / HTTP/1.1\r\nHost: a\r\n\r\n"


class Loop:
    """Keeps what is to be called later, and does nothing by itself."""

    def __init__(self):
        self.calls, self.work, self.now = {}, [], 0.0

    def call_later(self, delay, act):
        handle = Call(self, act)
        self.calls[handle] = delay
        return handle

    def create_task(self, work, **_):
        self.work.append(work)
        return asyncio.Future(loop=self)

    def get_debug(self):
        return False

    def time(self):
        self.now += 1.0
        return self.now

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


def connected(loop, state):
    """A connection to a server in this state."""
    protocol, transport = PromptProtocol(uvicorn.Config(answered, ws="none"), state, {}, _loop=loop), Transport()
    protocol.connection_made(transport)
    return protocol, transport


@pytest.fixture
def connection():
    loop = Loop()
    protocol, transport = connected(loop, ServerState())
    yield protocol, loop, transport
    for work in loop.work:
        work.close()


@rows("sent", [b"", b"GET / HT", WHOLE[:-2], b"POST / HTTP/1.1\r\nHost: a\r\nX: "])
def test_half_a_request_is_closed(sent):
    loop = Loop()
    protocol, transport = connected(loop, ServerState())
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


def test_of_too_many_connections_the_oldest_that_asks_for_nothing_is_closed():
    loop, state = Loop(), ServerState()
    many = [connected(loop, state) for _ in range(MOST)]
    many[0][0].data_received(WHOLE)
    many += [connected(loop, state) for _ in range(3)]
    assert all(transport.closed for _, transport in many[1:4])
    assert not any(transport.closed for _, transport in [many[0], *many[4:]])
    loop.work.pop().close()

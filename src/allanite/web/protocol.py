"""HTTP as the server of the page speaks it: connections that ask for nothing are closed, so that others find room."""

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

PATIENCE = 10.0
"""Seconds in which the head of a request has to come whole; a browser on this machine takes milliseconds."""

MOST = 200
"""Connections beyond which the oldest that asks for nothing is closed; Linux gives a process 1024 files."""

AT_ONCE = 64
"""Connections that are taken at once, before those that are too many are closed."""


class PromptProtocol(H11Protocol):
    """Closes a connection whose request does not come in time, or that is in the way of others."""

    late: asyncio.TimerHandle | None = None
    begun = 0.0

    @property
    def idle(self) -> bool:
        """Whether it is asked for nothing at the moment."""
        return self.cycle is None or self.cycle.response_complete

    @property
    def is_open(self) -> bool:
        """Whether it is not being closed already."""
        return not self.transport.is_closing()

    def connection_made(self, transport: Any) -> None:
        """Begin to wait for the first request."""
        super().connection_made(transport)
        self.begun = self.loop.time()
        all_open = [other for other in self.connections if isinstance(other, PromptProtocol) and other.is_open]
        if len(all_open) > MOST:
            min((other for other in all_open if other.idle), key=lambda other: other.begun).transport.close()
        self._wait()

    def data_received(self, data: bytes) -> None:
        """Take a part of a request, and wait for the rest of its head."""
        super().data_received(data)
        self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no more."""
        super().connection_lost(exc)
        self._stop()

    def _wait(self) -> None:
        if not self.idle:  # the head is there
            self._stop()
        elif self.late is None:
            self.late = self.loop.call_later(PATIENCE, self.transport.close)

    def _stop(self) -> None:
        if self.late is not None:
            self.late.cancel()
            self.late = None

"""HTTP as the server of the page speaks it, what a request says, and what is answered to an error."""

import asyncio
import json
from typing import Any

from fastapi import Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse
from uvicorn.protocols.http.h11_impl import H11Protocol

from allanite.core.errors import AllaniteError, UsageError

from .requests import problem_of
from .schema import faults, fitting
from .store import FullError, MissingError
from .workers import ProblemError

HEAD_TIMEOUT_S = 10.0
"""Seconds in which the head of a request has to come whole; a browser on this machine takes milliseconds."""

MAX_CONNECTIONS = 200
"""Connections beyond which the oldest that asks for nothing is closed; Linux gives a process 1024 files."""

MAX_ACCEPTED = 64  # connections that are taken at once, before those that are too many are closed


class PromptProtocol(H11Protocol):
    """Closes a connection whose request does not come in time, or that is in the way of others."""

    late: asyncio.TimerHandle | None = None
    begun = 0.0

    @property
    def idle(self) -> bool:
        """Whether it is asked for nothing at the moment."""
        return self.cycle is None or self.cycle.response_complete

    def connection_made(self, transport: Any) -> None:
        """Begin to wait for the first request."""
        super().connection_made(transport)
        self.begun = self.loop.time()
        every = [other for other in self.connections if isinstance(other, PromptProtocol)]
        all_open = [other for other in every if not other.transport.is_closing()]
        if len(all_open) > MAX_CONNECTIONS:
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
            self.late = self.loop.call_later(HEAD_TIMEOUT_S, self.transport.close)

    def _stop(self) -> None:
        if self.late is not None:
            self.late.cancel()
            self.late = None


MAX_BODY_BYTES = 1_000_000  # bytes of a request that is no upload


async def body_of(request: Request, schema: Any) -> Any:
    """The body of a request, as its schema says."""
    body = b""
    async for chunk in request.stream():
        body += chunk
        if len(body) > MAX_BODY_BYTES:
            raise UsageError(f"a request has at most {MAX_BODY_BYTES} bytes")
    return fitting(schema, body or b"{}")


class Answer(JSONResponse):
    """JSON in ASCII: whatever a text is made of, it can be sent."""

    def render(self, content: Any) -> bytes:
        """The body."""
        return json.dumps(content, allow_nan=False).encode("ascii")


ANSWERED: tuple[Any, ...] = (AllaniteError, ProblemError, RequestValidationError, HTTPException, Exception)
"""Kinds of errors that are answered."""


def answered(request: Request, error: Exception) -> JSONResponse:
    """What is answered to an error."""
    if isinstance(error, ProblemError):
        return Answer(error.data, 500 if error.data["exit"] == 1 else 400)
    if isinstance(error, HTTPException):
        return Answer(problem_of(UsageError(str(error.detail))), error.status_code)
    if isinstance(error, RequestValidationError):
        error = UsageError(faults(error))
    statuses = ((MissingError, 404), (FullError, 413), (AllaniteError, 400), (Exception, 500))
    return Answer(problem_of(error), next(status for kind, status in statuses if isinstance(error, kind)))

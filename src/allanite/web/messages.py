"""What a request says, and what is answered to an error."""

import json
from typing import Any

from fastapi import Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse

from allanite.core.errors import AllaniteError, UsageError

from .requests import problem_of
from .schema import faults, fitting
from .store import FullError, MissingError
from .workers import ProblemError

LONGEST = 1_000_000
"""Bytes of a request that is no upload."""


async def body_of(request: Request, schema: Any) -> Any:
    """The body of a request, as its schema says."""
    body = b""
    async for chunk in request.stream():
        body += chunk
        if len(body) > LONGEST:
            raise UsageError(f"a request has at most {LONGEST} bytes")
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

"""What a request says, and what is answered to an error."""

import json
from typing import Any

from fastapi import Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse

from allanite.core.errors import AllaniteError, UsageError

from .requests import problem_of
from .store import FullError, MissingError
from .workers import ProblemError

LONGEST = 1_000_000
"""Bytes of a request that is no upload."""


async def body_of(request: Request, most: int = LONGEST) -> dict[str, Any]:
    """The object in the body of a request."""
    body = b""
    async for chunk in request.stream():
        body += chunk
        if len(body) > most:
            raise UsageError(f"a request has at most {most} bytes")
    try:
        found = json.loads(body or b"{}")
    except ValueError as error:
        raise UsageError(f"the request is not JSON: {error}") from None
    if not isinstance(found, dict):
        raise UsageError("the request is not an object of JSON")
    return found


ANSWERED: tuple[Any, ...] = (AllaniteError, ProblemError, RequestValidationError, HTTPException, Exception)
"""Kinds of errors that are answered."""


def answered(request: Request, error: Exception) -> JSONResponse:
    """What is answered to an error."""
    if isinstance(error, ProblemError):
        return JSONResponse(error.data, 500 if error.data["exit"] == 1 else 400)
    if isinstance(error, HTTPException):
        return JSONResponse(problem_of(UsageError(str(error.detail))), error.status_code)
    if isinstance(error, RequestValidationError):
        error = UsageError("; ".join(f"{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors()))
    statuses = ((MissingError, 404), (FullError, 413), (AllaniteError, 400), (Exception, 500))
    return JSONResponse(problem_of(error), next(status for kind, status in statuses if isinstance(error, kind)))

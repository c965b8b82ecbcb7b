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


def _refused(request: Request, error: Exception) -> JSONResponse:
    status = 404 if isinstance(error, MissingError) else 413 if isinstance(error, FullError) else 400
    return JSONResponse(problem_of(error), status)


def _problem(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, ProblemError)  # noqa: S101 - the table says so
    return JSONResponse(error.data, 500 if error.data["exit"] == 1 else 400)


def _invalid(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)  # noqa: S101 - the table says so
    words = "; ".join(f"{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors())
    return JSONResponse({"error": words, "option": None, "exit": 2}, 400)


def _http(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)  # noqa: S101 - the table says so
    return JSONResponse({"error": str(error.detail), "option": None, "exit": 2}, error.status_code)


def _defect(request: Request, error: Exception) -> JSONResponse:
    return JSONResponse(problem_of(error), 500)


ANSWERS: dict[Any, Any] = {
    AllaniteError: _refused, ProblemError: _problem, RequestValidationError: _invalid, HTTPException: _http,
    Exception: _defect,
}  # fmt: skip
"""Kind of an error: what is answered."""

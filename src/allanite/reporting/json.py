"""Results as JSON."""

import json
import math
from typing import Any, Protocol

from allanite.parallel.sharing import Work, made
from allanite.study.job import Job


class Plain(Protocol):
    """Whatever can become plain data."""

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""


def to_json(value: Plain) -> str:
    """Strictly valid JSON; NaN and infinity become null."""
    return made(json_of(value))


def json_of(value: Plain) -> Work[str]:
    """The making of the same; that of a job by channels."""
    data = value.written() if isinstance(value, Job) else Work.one(value.to_dict)
    return data.then(lambda found: json.dumps(_strict(found), allow_nan=False, ensure_ascii=False) + "\n")


def _strict(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _strict(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_strict(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value

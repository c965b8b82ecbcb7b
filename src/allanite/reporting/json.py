"""Results as JSON."""

import json
import math
from typing import Any, Protocol


class Plain(Protocol):
    """Whatever can become plain data."""

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""


def to_json(value: Plain) -> str:
    """Strictly valid JSON; NaN and infinity become null."""
    made = value.to_dict()
    try:
        text = json.dumps(made, allow_nan=False, ensure_ascii=False)
    except ValueError:
        text = json.dumps(_strict(made), allow_nan=False, ensure_ascii=False)
    return text + "\n"


def _strict(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _strict(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_strict(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value

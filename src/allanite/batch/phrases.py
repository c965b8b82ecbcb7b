"""Plain data as JSON in which phrases keep how they were made, so that a stored result is shown in any language."""

import json
from typing import Any

from allanite.phrases.phrase import Phrase

TEMPLATES, FIELDS = "say", "with"
"""Keys of a phrase."""


def dumps(data: Any) -> str:
    """Plain data as JSON.

    Examples
    --------
    >>> from allanite.phrases.phrase import say
    >>> dumps({"what": say("at {f:g} Hz", f=2.5), "name": "gx"})
    '{"name": "gx", "what": {"say": ["at {f:g} Hz"], "with": {"f": 2.5}}}'
    >>> loads(_)["what"]
    'at 2.5 Hz'
    """
    return json.dumps(_taken_apart(data), sort_keys=True)


def loads(text: str) -> Any:
    """The data that `dumps` has written."""
    return json.loads(text, object_hook=_phrase)


def _taken_apart(data: Any) -> Any:
    if isinstance(data, Phrase):
        return {TEMPLATES: list(data.templates), FIELDS: _taken_apart(dict(data.fields))}
    if isinstance(data, dict):
        return {key: _taken_apart(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_taken_apart(value) for value in data]
    return data.item() if hasattr(data, "item") else data


def _phrase(data: dict[str, Any]) -> Any:
    if data.keys() != {TEMPLATES, FIELDS}:
        return data
    return Phrase(tuple(data[TEMPLATES]), data[FIELDS])

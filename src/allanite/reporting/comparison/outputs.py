"""The files that a comparison or a pool can become."""

from collections.abc import Callable
from pathlib import PurePath

from .sheets import Value


def _page(value: Value, _: str) -> bytes:
    from .html import page

    return page(value).encode()


def _figure(value: Value, path: str) -> bytes:
    from allanite.reporting.style import encode

    from .figures import plot_comparison

    return encode(plot_comparison(value), PurePath(path).suffix.lower().lstrip("."))


def _json(value: Value, _: str) -> bytes:
    from allanite.reporting.plain import to_json

    return to_json(value).encode()


def _csv(value: Value, _: str) -> bytes:
    from .plain import to_csv

    return to_csv(value).encode()


OUTPUTS: dict[str, Callable[[Value, str], bytes]] = {"report": _page, "plot": _figure, "json": _json, "csv": _csv}
"""Name of the option that asks for it: what the file holds."""

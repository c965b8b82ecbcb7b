"""What other packages add: objects behind the entry points of a group, and tables that hold them beside their own rows.

The groups are ``allanite.readers`` (modules that read a format), ``allanite.statistics``, ``allanite.terms`` and
``allanite.targets`` (rows of tables), ``allanite.verbs`` (commands), ``allanite.values`` and ``allanite.views``
(results by the names of their types, and how they are shown). Nothing is looked for until a table is asked for a name
that it has not, or is listed. What is broken is named by a `PluginWarning` and left out.
"""

import warnings
from collections.abc import ItemsView, Iterator, KeysView, Mapping, ValuesView
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from threading import get_ident
from typing import Any, TypeVar, cast, overload

Row = TypeVar("Row")
Other = TypeVar("Other")

_loaded: dict[str, dict[str, Any]] = {}
_loading: set[tuple[str, int]] = set()


class PluginWarning(UserWarning):
    """A plug-in that is broken or refused, and left out."""


def named(group: str) -> Mapping[str, Any]:
    """The objects of a group by the names of their entry points, loaded once.

    Examples
    --------
    >>> dict(named("allanite.nothing"))
    {}
    """
    own = group, get_ident()
    if group not in _loaded and own not in _loading:  # a plug-in that is being imported sees the table without itself
        _loading.add(own)
        found: dict[str, Any] = {}
        try:
            for entry in entries(group):
                try:
                    found[entry.name] = entry.load()
                except Exception as error:  # noqa: BLE001, RUF100 - whatever it does, others are not affected
                    leave_out(group, entry.name, f"it cannot be loaded: {type(error).__name__}: {error}")
        finally:
            _loading.discard(own)
        _loaded[group] = found
    return _loaded.get(group, {})


def rows(group: str) -> list[Any]:
    """The objects of a group, in the order of their names."""
    return list(named(group).values())


@cache
def entries(group: str) -> tuple[EntryPoint, ...]:
    """The entry points of a group, by name; the first of those with one name."""
    every = {entry.name: entry for entry in reversed([*entry_points(group=group)])}
    return tuple(every[name] for name in sorted(every))


def broken(group: str, name: str, why: str) -> str:
    """What is wrong with a plug-in, as a sentence that names its package."""
    entry = next((entry for entry in entries(group) if entry.name == name), None)
    package = "" if entry is None else entry.dist.name if entry.dist else entry.value
    what = group.rpartition(".")[2].removesuffix("s")
    return f"the {what} plugin {name!r} of the package {package!r} is broken ({why}); update or remove it"


def leave_out(group: str, name: str, why: str) -> None:
    """Say that a plug-in is left out."""
    warnings.warn(broken(group, name, why), PluginWarning, stacklevel=3)


class Table(dict[str, Row]):
    """Rows by name, and those of the plug-ins of a group, loaded when an unknown name is asked for or all are listed.

    A plug-in with a name that a row has already is left out, and so is one that is no row of this kind.

    Examples
    --------
    >>> table = Table({"one": 1}, "allanite.nothing", kind=int, key="real")
    >>> table["one"], "two" in table, list(table)
    (1, False, ['one'])
    """

    def __init__(self, own: Mapping[str, Row], group: str, *, kind: type, key: str = "") -> None:
        super().__init__(own)
        self._group, self._kind, self._key, self._whole = group, kind, key, False

    def _complete(self) -> None:
        if self._whole:
            return
        found = named(self._group)
        if self._whole or self._group not in _loaded:
            return
        self._whole = True
        for name, row in found.items():
            symbol: Any = getattr(row, self._key, None) if self._key else name
            if not isinstance(row, self._kind):
                leave_out(self._group, name, f"it is a {type(row).__name__}, not a {self._kind.__name__}")
            elif dict.__contains__(self, symbol):
                leave_out(self._group, name, f"the name {symbol!r} exists already")
            else:
                self[symbol] = cast(Row, row)

    def __missing__(self, name: str) -> Row:
        self._complete()
        if dict.__contains__(self, name):
            return self[name]
        raise KeyError(name)

    def __contains__(self, name: object) -> bool:
        return dict.__contains__(self, name) or (not self._whole and name in self.keys())

    def __iter__(self) -> Iterator[str]:
        self._complete()
        return super().__iter__()

    def __len__(self) -> int:
        self._complete()
        return super().__len__()

    def keys(self) -> KeysView[str]:  # type: ignore[override]  # dict_keys, which typeshed keeps to itself
        """The names."""
        self._complete()
        return super().keys()

    def values(self) -> ValuesView[Row]:  # type: ignore[override]
        """The rows."""
        self._complete()
        return super().values()

    def items(self) -> ItemsView[str, Row]:  # type: ignore[override]
        """Names and rows."""
        self._complete()
        return super().items()

    @overload
    def get(self, name: str, default: None = None, /) -> Row | None: ...
    @overload
    def get(self, name: str, default: Row | Other, /) -> Row | Other: ...

    def get(self, name: str, default: Any = None, /) -> Any:
        """The row of a name, or something else."""
        self._complete()
        return super().get(name, default)

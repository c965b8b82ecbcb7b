"""What other packages add: objects behind the entry points of a group, and tables that hold them beside their own rows.

The groups are ``allanite.readers`` (modules that read a format), ``allanite.statistics``, ``allanite.terms``,
``allanite.targets``, ``allanite.datasheets`` and ``allanite.verbs`` (rows of tables), and ``allanite.views`` (how
results are shown, by the names of their types). Nothing is looked for until a table is asked for a name that it has
not, or is listed. What is broken, or has a name that is taken, is left out, and named by a `PluginWarning`.
"""

import warnings
from collections.abc import ItemsView, Iterator, KeysView, Mapping, ValuesView
from contextlib import contextmanager
from functools import cache
from threading import get_ident
from typing import TYPE_CHECKING, Any, TypeVar, cast, overload

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

Row = TypeVar("Row")
Other = TypeVar("Other")

_loaded: "dict[str, tuple[tuple[EntryPoint, Any], ...]]" = {}
_loading: set[tuple[str, int]] = set()


class PluginWarning(UserWarning):
    """A plug-in that is broken or refused, and left out."""


def plugins(group: str) -> "tuple[tuple[EntryPoint, Any], ...]":
    """The entry points of a group with their objects, by name, loaded once.

    >>> plugins("allanite.nothing")
    ()
    """
    own = group, get_ident()
    if group not in _loaded and own not in _loading:  # a plug-in that is being imported sees the table without itself
        _loading.add(own)
        pairs = []
        try:
            for entry in sorted(_entry_points().select(group=group), key=lambda entry: entry.name):
                try:
                    pairs.append((entry, entry.load()))
                except (Exception, SystemExit) as error:  # noqa: BLE001, RUF100 - others are not affected
                    leave_out(entry, f"it cannot be loaded: {type(error).__name__}: {error}")
        finally:
            _loading.discard(own)
        _loaded[group] = tuple(pairs)
    return _loaded.get(group, ())


@cache
def _entry_points() -> Any:
    """Those of all packages, whose files are read once."""
    from importlib.metadata import entry_points

    return entry_points()


def broken(entry: "EntryPoint", why: str) -> str:
    """What is wrong with a plug-in, as a sentence that names its package."""
    package, what = entry.dist.name if entry.dist else entry.value, entry.group.rpartition(".")[2].removesuffix("s")
    return f"the {what} plugin {entry.name!r} of the package {package!r} is broken ({why}); update or remove it"


def leave_out(entry: "EntryPoint", why: str) -> None:
    """Say that a plug-in is left out."""
    warnings.warn(broken(entry, why), PluginWarning, stacklevel=3)


class Registry(dict[str, Row]):
    """Rows by name, and those of the plug-ins of a group, loaded when an unknown name is asked for or all are listed.

    A plug-in with a name that a row has already is left out, and so is one that is no row of this kind. The name is the
    attribute `key` of a row, otherwise that of its entry point.

    >>> table = Registry({"one": 1}, "allanite.nothing", kind=int, key="real")
    >>> table["one"], "two" in table, list(table)
    (1, False, ['one'])
    """

    def __init__(self, own: Mapping[str, Row], group: str, *, kind: type, key: str = "") -> None:
        super().__init__(own)
        self._group, self._kind, self._key, self._whole = group, kind, key, False

    @contextmanager
    def trying(self, name: str, row: Row) -> Iterator[None]:
        """The table with a row in it, in place of one of this name, until the end of the context."""
        before = self.get(name)
        self[name] = row
        try:
            yield
        finally:
            if before is None:
                del self[name]
            else:
                self[name] = before

    def _complete(self) -> None:
        if self._whole:
            return
        rows = plugins(self._group)
        if self._group not in _loaded:
            return
        for entry, row in rows:
            name: Any = getattr(row, self._key, None) if self._key else entry.name
            if not isinstance(row, self._kind):
                leave_out(entry, f"it is a {type(row).__name__}, not a {self._kind.__name__}")
            elif super().get(name, row) is not row:  # another thread may have put it there just now
                leave_out(entry, f"the name {name!r} exists already")
            else:
                self[name] = cast(Row, row)
        self._whole = True

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
        try:
            return self[name]
        except KeyError:
            return default

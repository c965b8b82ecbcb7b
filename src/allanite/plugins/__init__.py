"""What other packages add: objects behind the entry points of a group, and tables that hold them beside their own rows.

The groups are ``allanite.readers`` (modules that read a format), ``allanite.statistics``, ``allanite.terms``,
``allanite.targets``, ``allanite.datasheets`` and ``allanite.verbs`` (rows of tables), and ``allanite.views`` (how
results are shown, by the names of their types). Nothing is looked for until a table is asked for a name that it has
not, or is listed. What is broken, or has a name that is taken, is left out, and named by a `PluginWarning`.
"""

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from itertools import chain
from threading import get_ident
from traceback import walk_tb
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

DECLARED = "allanite.core.declared"
"""The module that compares values with declared types; it stands above this one, and is imported for a plug-in."""

FAILURES = (Exception, SystemExit)
"""What the code of another package may raise without ending the program."""

Row = TypeVar("Row")

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
                except FAILURES as error:
                    leave_out(entry, f"it cannot be loaded: {told(error)}")
        finally:
            _loading.discard(own)
        _loaded[group] = tuple(pairs)
    return _loaded.get(group, ())


@cache
def _entry_points() -> Any:
    """Those of all packages, whose files are read once; where a file is malformed, those of the other packages."""
    from importlib.metadata import EntryPoints, distributions, entry_points

    try:
        return entry_points()
    except Exception:  # noqa: BLE001, RUF100 - it does not say whose file it is
        sound: dict[str, Iterable[EntryPoint]] = {}
    for package in distributions():
        try:
            sound.setdefault(package.name, package.entry_points)
        except Exception as error:  # noqa: BLE001, RUF100 - others are not affected
            if "[allanite." in _text_of(package):
                what = f"the entry points of the package {package.name!r} cannot be read ({told(error)})"
                warnings.warn(f"{what}, and its plugins are left out; update or remove it", PluginWarning, stacklevel=4)
    return EntryPoints(chain.from_iterable(sound.values()))


def _text_of(package: Any) -> str:
    try:
        return package.read_text("entry_points.txt") or ""
    except UnicodeDecodeError as error:
        return error.object.decode("latin-1")


def told(error: BaseException) -> str:
    """The type of an error of other code, and what it says if it can."""
    try:
        return f"{type(error).__name__}: {error}".removesuffix(": ")
    except FAILURES:
        return type(error).__name__


def package_of(entry: "EntryPoint") -> str:
    """The name of the package of a plug-in; its module where the metadata are damaged."""
    try:
        return str((entry.dist and entry.dist.metadata["Name"]) or entry.value)
    except Exception:  # noqa: BLE001, RUF100 - what is no text, or cannot be read
        return entry.value


def broken(entry: "EntryPoint", why: str) -> str:
    """What is wrong with a plug-in, as a sentence that names its package."""
    what = f"the {entry.group.rpartition('.')[2].removesuffix('s')} plugin {entry.name!r}"
    return f"{what} of the package {package_of(entry)!r} is broken ({why}); update or remove it"


def raised_in(error: BaseException) -> str:
    """The package of the plug-in that ran where an error was raised; empty if none did."""
    entries = (entry for pairs in _loaded.values() for entry, _ in pairs)
    packages = {entry.value.partition(":")[0].partition(".")[0]: package_of(entry) for entry in entries}
    frames = (str(frame.f_globals.get("__name__")).partition(".")[0] for frame, _ in walk_tb(error.__traceback__))
    return next((packages[name] for name in reversed([*frames]) if name in packages and name != "allanite"), "")


def leave_out(entry: "EntryPoint", why: str) -> None:
    """Say that a plug-in is left out."""
    warnings.warn(broken(entry, why), PluginWarning, stacklevel=3)


class Registry(Mapping[str, Row]):
    """Rows by name, and those of the plug-ins of a group, loaded when an unknown name is asked for or all are listed.

    A plug-in with a name that a row has already is left out, and so is one that is no row of this kind. The name is the
    attribute `key` of a row, otherwise that of its entry point. `demand` raises what else is wrong with a row.

    >>> table = Registry({"one": 1}, "allanite.nothing", kind=int, key="real")
    >>> table["one"], "two" in table, list(table)
    (1, False, ['one'])
    """

    def __init__(self, own: Mapping[str, Row], group: str, *, kind: type, key: str = "",
                 demand: Callable[[Any], None] = lambda row: None) -> None:  # fmt: skip
        self._rows = dict(own)
        self._group, self._kind, self._key, self._demand, self._whole = group, kind, key, demand, False

    @contextmanager
    def trying(self, name: str, row: Row) -> Iterator[None]:
        """The table with a row in it, in place of one of this name, until the end of the context."""
        before = self.get(name)
        self._rows[name] = row
        try:
            yield
        finally:
            if before is None:
                del self._rows[name]
            else:
                self._rows[name] = before

    def _complete(self) -> None:
        rows = () if self._whole else plugins(self._group)
        own = f"{self._group} judged", get_ident()
        if self._whole or self._group not in _loaded or own in _loading:  # a row that is judged is not in the table yet
            return
        _loading.add(own)
        for entry, row in rows:
            try:
                name, why = self._judged(entry.name, row)
            except FAILURES as error:
                name, why = "", told(error)
            if why:
                leave_out(entry, why)
            else:
                self._rows[name] = row
        _loading.discard(own)
        self._whole = True

    def _judged(self, name: Any, row: Any) -> tuple[str, str]:
        """The name of a row of a plug-in, and why it is left out."""
        if not isinstance(row, self._kind):
            return "", f"it is a {type(row).__name__}, not a {self._kind.__name__}"
        name, declared = getattr(row, self._key) if self._key else name, import_module(DECLARED)
        for field, hint in declared.fields_of(self._kind).items():
            if expected := declared.misfit(value := getattr(row, field), hint):
                return "", f"its {field} must be {expected}, not {value!r}"
        if not (name.isprintable() and name.strip() == name != ""):
            return "", f"{name!r} is no name"
        self._demand(row)
        if self._rows.get(name, row) is not row:  # another thread may have put it there just now
            return "", f"the name {name!r} exists already"
        return name, ""

    def __getitem__(self, name: str) -> Row:
        if name not in self._rows:
            self._complete()
        return self._rows[name]

    def __iter__(self) -> Iterator[str]:
        self._complete()
        return iter(self._rows)

    def __len__(self) -> int:
        self._complete()
        return len(self._rows)

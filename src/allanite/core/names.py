"""Names in tables: the row of a name, and what is meant by a name that is not in the table."""

from collections.abc import Container, Hashable, Iterable, Mapping, Sequence
from pathlib import PurePath
from typing import Any, TypeVar

from .errors import UsageError, given

Row = TypeVar("Row")

ALIKE = 0.7  # similarity, 0 to 1, from which a known name may be the one that was meant
LISTED = 12  # number of names up to which a message lists all of them although it suggests one


def nearest(name: object, known: Iterable[str]) -> str:
    """The known name that was meant: the most similar one, or the one whose row has the name among its `synonyms`."""
    # Upper case, hyphens and underscores do not matter. Empty if no known name is similar.
    from difflib import get_close_matches

    own: dict[str, str] = {}
    for word in known:
        row = known[word] if isinstance(known, Mapping) else None
        own |= dict.fromkeys(map(_plain, (*getattr(row, "synonyms", ()), word)), word)
    similar = get_close_matches(_plain(str(name)), own, n=1, cutoff=ALIKE)
    return own[similar[0]] if similar else ""


def _plain(name: str) -> str:
    return name.lower().translate(dict.fromkeys(map(ord, "-_ "))) or name


def unknown(what: str, name: object, known: Iterable[str], *, where: str = "", choice: str = "", lister: str = "",
            listed: bool = True) -> UsageError:  # fmt: skip
    """The error of an unknown name of `what`, such as a statistic: the name that may be meant, and the known ones."""
    # Of many names a `lister`, a command, is named instead, or the first are.
    meant, names = nearest(name, known), list(known)
    words = f"unknown {what} {given(name)}{where}" + (f"; did you mean {meant}?" if meant else "")
    if lister:
        words += "" if meant else f"; '{lister}' lists them"
    elif listed and (not meant or len(names) <= LISTED):
        words += f"{' Known' if meant else '; known'} {what}s: " + ", ".join(names[:LISTED])
        words += f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return UsageError(words, choice=choice, cure=(str(name), meant) if meant else ("", ""))


def demand_name(what: str, name: object, known: Iterable[str], **form: Any) -> None:
    """Refuse a name that is not known; `form` is that of `unknown`."""
    inside = known if isinstance(known, Container) else list(known)
    if not isinstance(name, Hashable) or name not in inside:
        raise unknown(what, name, known, **form)


def row_of(what: str, name: Any, table: Mapping[str, Row], **form: Any) -> Row:
    """The row of a name; an unknown one is refused as by `demand_name`."""
    demand_name(what, name, table, **form)
    return table[name]


def row_alike(what: str, name: Any, table: Mapping[str, Row], **form: Any) -> Row:
    """The row of a name in which upper case, hyphens, underscores and spaces do not matter; or refused as by `row_of`.

    >>> row_alike("target", "LIO_SAM", {"lio-sam": 1})
    1
    """
    if isinstance(name, str) and name not in table:
        name = next((known for known in table if _plain(known) == _plain(name)), name)
    return row_of(what, name, table, **form)


def told_apart(paths: Sequence[str]) -> tuple[str, ...]:
    """The shortest names that tell files apart: with folders where the last names are equal, numbered where paths are.

    >>> told_apart(["/data/a.csv", "/data/b.csv"]), told_apart(["/data/before/run.csv", "/data/after/run.csv"])
    (('a.csv', 'b.csv'), ('before/run.csv', 'after/run.csv'))
    >>> told_apart(["/1/imu/raw/run.csv", "/2/imu/raw/run.csv"]), told_apart(["a.csv", "a.csv"])
    (('1/…/run.csv', '2/…/run.csv'), ('a.csv 1', 'a.csv 2'))
    """
    parts = [PurePath(path).parts for path in paths]
    depth = next(k for k in range(1, max(map(len, parts), default=0) + 2) if _as_many([p[-k:] for p in parts], parts))
    tails = [p[-depth:] for p in parts]
    short = [(tail[0], "…", tail[-1]) if len(tail) > 2 else tail for tail in tails]
    names = [PurePath(*tail).as_posix() for tail in (short if _as_many(short, parts) else tails)]
    numbers = (f" {names[:i].count(name) + 1}" if names.count(name) > 1 else "" for i, name in enumerate(names))
    return tuple(map("".join, zip(names, numbers, strict=True)))


def sources_of(provenance: Mapping[str, str]) -> list[str]:
    """The files of a result, ``source``, ``source 2`` and so on of its provenance."""
    return [path for key, path in provenance.items() if key.split()[0] == "source" and path]


def _as_many(some: Sequence[Hashable], others: Sequence[Hashable]) -> bool:
    """Whether both have the same number of different items."""
    return len(set(some)) == len(set(others))

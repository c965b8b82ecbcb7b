"""Checks of a row by their names, and those that are known to fail, each with its reason."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from types import MappingProxyType

from allanite.core.names import demand_name
from allanite.plugins import told

NONE: Mapping[str, str] = MappingProxyType({})
"""No check is expected to fail."""

CHECKS: dict[str, tuple[str, ...]] = {
    "reader": ("parts", "sniff", "channels", "cut_off"),
    "statistic": ("texts", "factors", "order", "windows", "mean"),
    "noise term": ("asymptote", "scaled", "law", "derivatives", "sums", "increments", "oscillates", "spectra",
                   "transforms", "waveforms", "states", "simulated"),
    "data sheet": ("document", "lines", "stored"),
    "target": ("source", "fields", "way_back"),
    "verb": ("help", "stored", "page", "absent"),
}  # fmt: skip
"""The names of the checks of each kind of row; docs/architecture.md says what each demands."""


@contextmanager
def checking(about: str, expected: Mapping[str, str]) -> Iterator[Callable[[str], AbstractContextManager[None]]]:
    """Within this context the value begins a check by its name; one that is expected to fail has to.

    >>> with checking("verb 'mine'", {"page": "it has no view yet"}) as check:
    ...     with check("page"):
    ...         assert False, "its result has no page"
    ...     with check("help"):
    ...         assert False, "it has no help"
    Traceback (most recent call last):
        ...
    AssertionError: verb 'mine': it has no help (check 'help')
    """
    failed = set[str]()
    known = next(names for kind, names in CHECKS.items() if about.startswith(kind))
    for name in expected:
        demand_name("check", name, known)

    @contextmanager
    def check(name: str) -> Iterator[None]:
        try:
            yield
        except Exception as error:
            if name not in expected:
                words = str(error) if isinstance(error, AssertionError) else told(error)
                raise AssertionError(f"{about}: {words} (check {name!r})") from error
            failed.add(name)

    yield check
    for name, reason in expected.items():
        words = f"the check {name!r} passes, but is expected to fail ({reason}): do not expect it"
        assert name in failed, f"{about}: {words}"

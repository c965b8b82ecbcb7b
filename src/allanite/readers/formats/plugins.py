"""Readers from other packages: entry points of the group ``allanite.readers``, each with TITLE, sniff and read."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from allanite.core.errors import AllaniteError, DataError, UsageError
from allanite.core.record import Recording
from allanite.readers.options import Options

GROUP = "allanite.readers"


@dataclass(frozen=True)
class Plugin:
    """A reader that another package brings; it is loaded when it is first asked."""

    entry: EntryPoint

    @cached_property
    def loaded(self) -> Any:
        """The module or object behind the entry point.

        Raises
        ------
        UsageError
            It cannot be imported, or lacks TITLE, sniff or read.
        """
        try:
            found = self.entry.load()
        except Exception as error:
            raise UsageError(self._broken(f"it cannot be loaded: {type(error).__name__}: {error}")) from error
        missing = [name for name in ("TITLE", "sniff", "read") if not hasattr(found, name)]
        if missing:
            raise UsageError(self._broken(f"it has no {', '.join(missing)}"))
        return found

    @property
    def TITLE(self) -> str:
        """What the format is called."""
        return str(self.loaded.TITLE)

    def sniff(self, head: bytes, suffix: str) -> bool:
        """Whether bytes and suffix look like the format."""
        return bool(self._called("sniff", head, suffix))

    def read(self, path: str, options: Options) -> Recording:
        """The recording that the plugin makes of the file."""
        recording = self._called("read", path, options)
        if not isinstance(recording, Recording):
            raise UsageError(self._broken(f"read gave a {type(recording).__name__} and not a Recording"))
        return recording

    def _called(self, name: str, *given: Any) -> Any:
        try:
            return getattr(self.loaded, name)(*given)
        except (AllaniteError, MemoryError):
            raise
        except Exception as error:
            raise DataError(self._broken(f"{name} failed: {type(error).__name__}: {error}")) from error

    def _broken(self, why: str) -> str:
        package = self.entry.dist.name if self.entry.dist else self.entry.value
        return (
            f"the reader plugin {self.entry.name!r} of the package {package!r} is broken ({why}); update or remove it"
        )


def plugins() -> Iterator[Plugin]:
    """The readers that are installed, by name."""
    for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name):
        yield Plugin(entry)

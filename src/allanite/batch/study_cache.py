"""Units whose studies wait on the disk: of a lot of thousands, only one is in memory."""

import pickle
import tempfile
import weakref
import zlib
from collections.abc import Callable
from typing import Any

from allanite.study.results import Study

from .batch import BatchUnit


class Spool:
    """A temporary file of studies, read again one at a time.

    Only this process writes and reads it; it has no name and is gone when nothing refers to it.

    Examples
    --------
    >>> from allanite.study.recipe import Recipe
    >>> load = Spool().put(Study((), Recipe(), (), (), {}))
    >>> len(load().channels)
    0
    """

    def __init__(self) -> None:
        self._file = tempfile.TemporaryFile(prefix="allanite-")  # noqa: SIM115 - closed with the spool
        weakref.finalize(self, self._file.close)
        self._last: tuple[int, Study] | None = None

    def put(self, study: Study) -> Callable[[], Study]:
        """Store a study; what reads it again."""
        begin = self._file.seek(0, 2)
        size = self._file.write(zlib.compress(pickle.dumps(study), 1))
        return lambda: self._get(begin, size)

    def _get(self, begin: int, size: int) -> Study:
        if self._last is None or self._last[0] != begin:
            self._file.seek(begin)
            found: Study = pickle.loads(zlib.decompress(self._file.read(size)))  # noqa: S301 - written by this process
            self._last = begin, found
        return self._last[1]


class SpooledUnit(BatchUnit):
    """A unit that reads its study whenever it is asked for it; stored and pickled as any other unit."""

    def __init__(self, unit: BatchUnit, load: Callable[[], Study]) -> None:
        super().__init__(unit.file, None, unit.judgements, unit.error, unit.judged)
        object.__setattr__(self, "_load", load)

    def __getattribute__(self, name: str) -> Any:
        return object.__getattribute__(self, "_load")() if name == "study" else object.__getattribute__(self, name)

    def __reduce__(self) -> tuple[Any, ...]:
        return BatchUnit, (self.file, self.study, self.judgements, self.error, self.judged)

    def to_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Those of the unit."""
        return BatchUnit(*self.__reduce__()[1]).to_dict(level)


def spooled(unit: BatchUnit, spool: Spool) -> BatchUnit:
    """The unit, without its study in memory."""
    return unit if unit.study is None else SpooledUnit(unit, spool.put(unit.study))

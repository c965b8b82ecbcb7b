"""Where the numbers of a job come from."""

from collections.abc import Mapping, Sequence

from allanite.core.record import Recording
from allanite.core.version import __version__


def provenance_of(*recordings: Recording) -> dict[str, str]:
    """Version and input files, for reproducing the result."""
    import platform

    made = {"allanite": __version__, "python": platform.python_version()}
    return made | joined([{"source": recording.source, "sha256": recording.digest} for recording in recordings])


def joined(provenances: Sequence[Mapping[str, str]]) -> dict[str, str]:
    """Those of several files as one: ``source``, ``source 2`` and so on."""
    first = dict(provenances[0]) if provenances else {}
    more = enumerate(provenances[1:], 2)
    return first | {f"{key} {i}": one[key] for i, one in more for key in ("source", "sha256") if key in one}

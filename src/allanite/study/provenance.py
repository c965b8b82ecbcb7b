"""Where the numbers of a job come from."""

from allanite.core.record import Recording
from allanite.core.version import __version__


def provenance_of(*recordings: Recording) -> dict[str, str]:
    """Version and input files, for reproducing the result."""
    import platform

    made = {"allanite": __version__, "python": platform.python_version()}
    for i, recording in enumerate(recordings, 1):
        which = "" if i == 1 else f" {i}"
        made |= {f"source{which}": recording.source, f"sha256{which}": recording.digest}
    return made

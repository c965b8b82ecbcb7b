"""Look every pinned version up in a folder of advisories: no network is asked.

    python tools/advisories.py FOLDER

FOLDER has advisories in the OSV format, as .json or .yaml: the unpacked export of OSV for PyPI, or a checkout of
github.com/pypa/advisory-database. Ends with exit code 1 if a version in constraints.txt has an open advisory that is
not accepted below.
"""

import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from packaging.utils import canonicalize_name
from packaging.version import Version

CONSTRAINTS = Path(__file__).resolve().parents[1] / "constraints.txt"
ACCEPTED = {
    "PYSEC-2023-163": "no version that mends it is listed; numexpr checks expressions since 2.8.5, and is given none",
    "PYSEC-2023-121": "of the program zstd before 1.5, which is not called; no version that mends it is listed",
}
"""Advisories that do not concern what allanite does, with the reason."""

READERS = {".json": json.loads, ".yaml": yaml.safe_load}


def pins(text: str) -> dict[str, Version]:
    """The versions of a file of constraints, by the name of the package."""
    pairs = (line.split("==") for line in text.splitlines() if "==" in line and not line.startswith("#"))
    return {canonicalize_name(name): Version(version) for name, version in pairs}


def advisories(folder: Path) -> Iterator[Mapping[str, Any]]:
    """The advisories in a folder that have not been withdrawn."""
    for path in sorted(folder.rglob("*")):
        if path.suffix in READERS:
            found = READERS[path.suffix](path.read_text("utf-8"))
            if isinstance(found, dict) and "affected" in found and "withdrawn" not in found:
                yield found


def concerns(version: Version, affected: Mapping[str, Any]) -> bool:
    """Whether a version is listed, or lies in a range: events switch it on and off in the order of versions.

    Examples
    --------
    >>> events = [{"introduced": "0"}, {"fixed": "2.11.3"}]
    >>> [concerns(Version(v), {"ranges": [{"type": "ECOSYSTEM", "events": events}]}) for v in ("2.11", "3.0")]
    [True, False]
    """
    ranges = (one["events"] for one in affected.get("ranges", ()) if one["type"] == "ECOSYSTEM")
    return str(version) in affected.get("versions", ()) or any(_within(version, events) for events in ranges)


def _within(version: Version, events: Iterable[Mapping[str, str]]) -> bool:
    inside = False
    for bound, kind in sorted((Version(value), kind) for event in events for kind, value in event.items()):
        passed = version > bound if kind == "last_affected" else version >= bound
        inside = kind == "introduced" if passed else inside
    return inside


def findings(pinned: Mapping[str, Version], known: Iterable[Mapping[str, Any]]) -> list[str]:
    """A line for each advisory that concerns a pinned version."""
    return [
        f"{name} {pinned[name]}: {advisory['id']}"
        for advisory in known
        for affected in advisory["affected"]
        if affected.get("package", {}).get("ecosystem") == "PyPI"
        and (name := canonicalize_name(affected["package"]["name"])) in pinned
        and concerns(pinned[name], affected)
    ]


def main() -> None:
    """Print what is found, and end with its exit code."""
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    pinned, known = pins(CONSTRAINTS.read_text()), list(advisories(Path(sys.argv[1])))
    if not known:
        sys.exit(f"{sys.argv[1]} has no advisory in the OSV format, as .json or .yaml")
    found = findings(pinned, known)
    reasons = {line: ACCEPTED.get(line.rpartition(" ")[2]) for line in found}
    print(*(f"{line} (accepted: {why})" if why else line for line, why in reasons.items()), sep="\n")
    print(f"{len(pinned)} versions, {len(known)} advisories, {len(found)} found")
    sys.exit(None in reasons.values())


if __name__ == "__main__":
    main()

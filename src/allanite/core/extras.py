"""Libraries that only some formats and commands need, and the command that installs them here."""

import importlib.util
import re
import sys
from importlib.metadata import requires
from pathlib import Path

from .errors import UsageError

INSTALLERS = {
    "pipx": "pipx inject allanite {names}",
    "uv tool": "uv tool install allanite -w {with_names}",
    "uv": "uv pip install {names}",
    "pip": "pip install {names}",
}
"""What adds libraries to an environment, by the program that made it."""


def demand_extra(extra: str, *modules: str, what: str = "this format") -> None:
    """Refuse what needs the libraries of an extra, and say how to install those that are missing."""
    if any(importlib.util.find_spec(name) is None for name in modules):
        names = requirements(extra)
        verb = "is" if len(names) == 1 else "are"
        raise UsageError(f"{what} needs {' and '.join(names)}, which {verb} not installed: {cure(names)}")


def requirements(extra: str) -> list[str]:
    """Names of the libraries of an extra."""
    mark = re.compile(rf"""extra == ["']{extra}["']""")
    return [re.split(r"[\s<>=!~;\[(]", line)[0].lower() for line in requires("allanite") or () if mark.search(line)]


def cure(names: list[str], prefix: Path | None = None) -> str:
    """The command that installs libraries into this environment, or the one at `prefix`."""
    where = Path(sys.prefix) if prefix is None else prefix
    return INSTALLERS[_installer(where)].format(names=" ".join(names), with_names=",".join(names))


def _installer(prefix: Path) -> str:
    if "pipx" in prefix.parts:
        return "pipx"
    if ("uv", "tools") in zip(prefix.parts, prefix.parts[1:], strict=False):
        return "uv tool"
    made = prefix / "pyvenv.cfg"
    return "uv" if made.is_file() and re.search(r"^uv\s*=", made.read_text("utf-8"), re.MULTILINE) else "pip"

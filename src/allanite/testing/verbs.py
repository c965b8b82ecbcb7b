"""A verb: its help, its JSON and back, and its refusal."""

import json
import tempfile
from pathlib import Path
from typing import Any, cast
from unittest.mock import patch

import click
from click.testing import CliRunner

from allanite.cli import VERBS, main
from allanite.core.plain import from_dict

DATA = {2, 3}
"""Exit codes of a refusal: wrong use, or wrong data."""


def check_verb(command: click.Command, *arguments: str) -> None:
    """Check that a verb has a help, that its JSON is read again, and that it refuses a file that is not there in words.

    Parameters
    ----------
    command : click.Command
    *arguments : str
        Of a run of it, the file it reads first.

    Raises
    ------
    AssertionError
        It does not; the message says what.
    """
    name = str(command.name)
    about = f"verb {name!r}:"
    assert command.get_short_help_str(), f"{about} it has no help"
    with patch.dict(cast(dict[str, Any], VERBS), {name: command}), tempfile.TemporaryDirectory() as folder:
        shown = CliRunner().invoke(main, [name, "--help"])
        assert shown.exit_code == 0, f"{about} --help ends with {shown.exit_code}: {shown.output}"
        path = Path(folder, "result.json")
        done = CliRunner().invoke(main, [name, *arguments, "--json", str(path)])
        assert done.exit_code == 0, f"{about} it ends with {done.exit_code}: {done.output}"
        data = json.loads(path.read_text("utf-8"))
        again = from_dict(data).to_dict()
        lost = [key for key in data if key in again and again[key] != data[key]]
        assert not lost, f"{about} what is read of its JSON differs in {', '.join(lost)}"
        if arguments:
            refused = CliRunner().invoke(main, [name, str(Path(folder, "there is no such.csv")), *arguments[1:]])
            assert refused.exit_code in DATA, f"{about} without its file it ends with {refused.exit_code}"
            assert "internal error" not in refused.output, f"{about} {refused.output}"
            assert "there is no such.csv" in refused.output, f"{about} it does not name the file: {refused.output}"

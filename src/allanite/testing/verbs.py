"""A verb: its help, its JSON and back, its result on a page, and its refusal."""

import json
import tempfile
from pathlib import Path
from typing import Any

from click.testing import CliRunner

from allanite.cli import VERBS, main
from allanite.cli.front import DATA, Verb
from allanite.core.aliases import public
from allanite.core.errors import UsageError
from allanite.core.plain import from_dict
from allanite.reporting import page

ABSENT = "there is no such file.csv"


@public
def check_verb(verb: Verb, *arguments: str) -> dict[str, Any]:
    """Check that a verb has a help, that its JSON is read again and shown, and that it refuses a file that is absent.

    Parameters
    ----------
    verb : Verb
        The row of `VERBS`.
    *arguments : str
        Of a run of it.

    Returns
    -------
    dict
        What it has written as JSON.

    Raises
    ------
    AssertionError
        It does not: ``verb 'extent': what is read of its JSON differs in low``.

    Examples
    --------
    >>> check_verb(VERBS["explain"], "vins-mono")["type"]
    'Explanation'
    """
    about = f"verb {verb.name!r}:"
    assert verb.group, f"{about} it has no heading of the help to stand below"
    assert verb.imported().get_short_help_str(), f"{about} it has no help"
    runner = CliRunner()
    with VERBS.trying(verb.name, verb), tempfile.TemporaryDirectory() as folder:
        shown = runner.invoke(main, [verb.name, "--help"])
        assert shown.exit_code == 0, f"{about} --help ends with {shown.exit_code}: {shown.output}"
        absent = [str(Path(folder, ABSENT)) if Path(word).is_file() else word for word in arguments]
        path = Path(folder, "result.json")
        done = runner.invoke(main, [verb.name, *arguments, "--json", str(path)])
        assert done.exit_code == 0, f"{about} it ends with {done.exit_code}: {done.output}"
        data: dict[str, Any] = json.loads(path.read_text("utf-8"))
        result = from_dict(data)
        again = result.to_dict()
        lost = [key for key in data if key in again and again[key] != data[key]]
        assert not lost, f"{about} what is read of its JSON differs in {', '.join(lost)}"
        try:
            page(result)
        except UsageError as error:
            raise AssertionError(f"{about} its result has no page: {error}") from error
        if absent != [*arguments]:
            refused = runner.invoke(main, [verb.name, *absent])
            assert refused.exit_code in {2, DATA}, f"{about} without its file it ends with {refused.exit_code}"
            assert "internal error" not in refused.output, f"{about} {refused.output}"
            assert ABSENT in " ".join(refused.output.split()), f"{about} it does not name the file: {refused.output}"
    return data

"""Words of the page that its own files have."""

import re
from pathlib import Path

import allanite as al


def test_every_word_is_there_in_each_language():
    folder = Path(al.__file__).parent / "web" / "static"
    texts = {path.name: path.read_text("utf-8") for path in folder.iterdir() if not path.name.startswith("plotly")}
    rows = dict(re.findall(r"^  (\w+): \[(.*)\],$", texts.pop("words.js"), re.MULTILINE))
    assert len(rows) > 100
    assert {key: row for key, row in rows.items() if len(re.findall(r'"[^"]+"', row)) != 3} == {}
    asked = re.findall(r'\bt\("(\w+)"\)|data-(?:word|label)="(\w+)"', "".join(texts.values()))
    assert len(asked) > 80
    assert {one or other for one, other in asked} <= rows.keys()

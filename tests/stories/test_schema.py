"""What every command writes as JSON is what the published schema says."""

import json
import shlex

import pytest
from tests import ALL, ROOT
from tests.rows import rows
from tests.verbs import ROWS, run

from allanite.cli import VERBS
from allanite.testing import check_verb

SCHEMA = json.loads((ROOT / "docs" / "static" / "results.schema.json").read_text("utf-8"))
KNOWN = {"$ref", "type", "const", "enum", "anyOf", "required", "properties", "items", "description"}
TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float),
         "null": type(None)}  # fmt: skip
UNLISTED = {"AnglePlan", "Batch", "Harmonics", "Lot", "Pool"}  # types of results that the schema does not have


def faults(value, schema, where="$"):
    """Where a value breaks a schema of the words in `KNOWN`, which are all that the schema uses."""
    assert set(schema) <= KNOWN | {"$schema", "title", "$defs"}, schema
    if "$ref" in schema:
        return faults(value, SCHEMA["$defs"][schema["$ref"].removeprefix("#/$defs/")], where)
    if "anyOf" in schema:
        each = [faults(value, one, where) for one in schema["anyOf"]]
        return [] if [] in each else min(each, key=len)
    if "const" in schema and value != schema["const"]:
        return [f"{where}: {value!r} is not {schema['const']!r}"]
    if "enum" in schema and value not in schema["enum"]:
        return [f"{where}: {value!r} is none of {schema['enum']}"]
    kind = schema.get("type")
    if kind and (not isinstance(value, TYPES[kind]) or (isinstance(value, bool) and kind != "boolean")):
        return [f"{where}: a {type(value).__name__}, not of type {kind}"]
    found = [f"{where}: no {name}" for name in schema.get("required", ()) if name not in value]
    for name, part in schema.get("properties", {}).items():
        if name in value:
            found += faults(value[name], part, f"{where}.{name}")
    for i, item in enumerate(value if "items" in schema else ()):
        found += faults(item, schema["items"], f"{where}[{i}]")
    return found


@pytest.mark.slow("every verb")
@rows("verb, line", [(verb, line) for verb, row in ROWS.items() for line in (row.runs if ALL else row.runs[:1])])
def test_output_is_what_the_schema_says(verb, line, furnished, to_the_end, monkeypatch):
    monkeypatch.chdir(furnished)
    run(f"{verb} {line} --json written.json --force", 3, 4, 5)
    written = json.loads((furnished / "written.json").read_text("utf-8"))
    roots = [one for one in SCHEMA["anyOf"] if one["$ref"].endswith(f"/{written['type']}")]
    assert len(roots) == (written["type"] not in UNLISTED), written["type"]
    assert [fault for root in roots for fault in faults(written, root)] == []


@pytest.mark.slow("every verb")
@rows("verb, line", [(verb, row.runs[0]) for verb, row in ROWS.items() if row.runs])
@pytest.mark.usefixtures("to_the_end")
def test_it_is_read_again_and_shown(verb, line, furnished, monkeypatch, tmp_path):
    for path in furnished.iterdir():
        (tmp_path / path.name).symlink_to(path)
    (tmp_path / "made.csv").unlink(missing_ok=True)  # no input
    monkeypatch.chdir(tmp_path)
    check_verb(VERBS[verb], *shlex.split(line))


def test_what_breaks_the_schema_is_found():
    curve = SCHEMA["$defs"]["Curve"]
    assert "$: no tau" in faults({"allanite": 1, "type": "Curve"}, curve)
    assert faults({"allanite": 2, "type": "Curve"}, {**curve, "required": []}) == ["$.allanite: 2 is not 1"]
    assert faults("absent", SCHEMA["$defs"]["Estimate"]["properties"]["status"]) == []
    assert faults("found", SCHEMA["$defs"]["Estimate"]["properties"]["status"])

"""What every command writes as JSON is what the published schema says."""

import json
import shlex

import pytest
from click.testing import CliRunner
from tests import ROOT

from allanite.cli import VERBS, main
from allanite.testing import check_verb

SCHEMA = json.loads((ROOT / "docs" / "static" / "results.schema.json").read_text("utf-8"))
KNOWN = {"$ref", "type", "const", "enum", "anyOf", "required", "properties", "items", "description"}
TYPES = {
    "object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float),
    "null": type(None),
}  # fmt: skip

SAMPLE = "examples/tactical_gyro.csv"
RUNS = {
    "info": f"info {SAMPLE}",
    "analyze": f"analyze {SAMPLE}",
    "deviation": f"deviation {SAMPLE} --channels gx --statistic adev,mtie",
    "spectrum": f"spectrum {SAMPLE} --channels gx --fit",
    "dynamic": f"dynamic {SAMPLE} --channels gx --window 600",
    "compare": f"compare {SAMPLE} --channels gx,gy",
    "check": f"check {SAMPLE} --claims 'N 0.2 deg/sqrt(h), B 5 deg/h, K 60 deg/h/sqrt(h)' --at-most",
    "watch": f"watch {SAMPLE} --rate 10 --unit deg/h --time time --channels gx --idle 0.1",
    "rate": f"rate {SAMPLE} --channels gx --interval 60",
    "angle": "angle plan --latitude 60 --duration 3600",
    "simulate": "simulate out.csv --sensor fog --rate 100 --duration 10",
    "plan": "plan --sensor fog --rate 100",
    "drift": "drift --sensor fog --require '1 deg in 10 min' --times 60,600",
    "selfcheck": "selfcheck --sensor rlg --rate 10 --duration 300 --records 2",
    "statespace": "statespace --sensor fog --rate 100",
    "export": f"export {SAMPLE} --to statespace",
    "convert": "convert '0.66 deg/sqrt(h)' --to kalibr",
    "explain": "explain vins-mono",
    "explain, a statistic": "explain theo1 --taus 9,75",
    "explain, a data sheet": "explain adis16470",
    "compare with a data sheet": f"compare {SAMPLE} --channels gx --datasheet adis16470",
    "convert, back": "convert --from px4 px4.params",
    "budget": f"budget {SAMPLE} --channels gx --stage 'output 16 300deg/s'",
    "compensate": "compensate warm.csv --regressors temp",
    "vertical": "vertical --gyro 'N 0.3 deg/sqrt(h)' --accelerometer 'N 100 ug/sqrt(Hz)'",
    "vertical of a recording": "vertical six.csv",
    "analyze, read off": f"analyze {SAMPLE} --channels gx --method slopes",
    "analyze, a channel refused": "analyze still.csv",
    "angle estimate": "angle estimate hour.csv --difference difference --latitude 60 --rho rho",
}
"""A run of every verb, and of what differs within one."""


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
    if "items" in schema:
        for i, item in enumerate(value):
            found += faults(item, schema["items"], f"{where}[{i}]")
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The sample, a file with a channel that never changes, one with a temperature, and an hour of a gimbal."""
    tmp_path = tmp_path_factory.mktemp("desk")
    (tmp_path / "examples").mkdir()
    sample = (ROOT / SAMPLE).read_text("utf-8")
    (tmp_path / SAMPLE).write_text(sample, "utf-8")
    rows = [line.split(",") for line in sample.splitlines() if line and line[0].isdigit()][:6000]
    still = "\n".join(f"{row[0]},{row[1]},1.0" for row in rows)
    (tmp_path / "still.csv").write_text(f"time [s],gx [deg/h],gy [deg/h]\n{still}\n", "utf-8")
    warm = "\n".join(f"{row[0]},{row[1]},{25 + i % 1000 / 100}" for i, row in enumerate(rows))
    (tmp_path / "warm.csv").write_text(f"time [s],gx [deg/h],temp [degC]\n{warm}\n", "utf-8")
    (tmp_path / "px4.params").write_text("1\t1\tEKF2_GYR_NOISE\t0.015\t9\n", "utf-8")
    level = ([0.001 * float(rate) for rate in row[1:3]] for row in rows)
    six = "\n".join(f"{','.join(row[:4])},{x:.6f},{y:.6f},9.8" for row, (x, y) in zip(rows, level, strict=True))
    heads = "time [s],gx [deg/h],gy [deg/h],gz [deg/h],ax [m/s^2],ay [m/s^2],az [m/s^2]"
    (tmp_path / "six.csv").write_text(f"{heads}\n{six}\n", "utf-8")
    command = f"angle simulate '{tmp_path}/hour.csv' --latitude 60 --duration 3600 --error h:128=3,-1"
    made = CliRunner().invoke(main, shlex.split(command))
    assert made.exit_code == 0, made.output
    return tmp_path


@pytest.fixture
def desk(folder, tmp_path, monkeypatch):
    """A folder with links to them."""
    for path in folder.iterdir():
        (tmp_path / path.name).symlink_to(path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_verb_is_tried():
    # example runs the others, batch writes tables, lot shows what analyze shows of many units
    assert set(VERBS) - {"example", "batch", "lot", "serve"} <= set(RUNS)


@pytest.mark.slow("takes more than half a second")
@pytest.mark.parametrize("run", RUNS)
def test_output_is_what_the_schema_says(desk, run):
    verb, *arguments = shlex.split(RUNS[run])
    written = check_verb(VERBS[verb], *arguments)
    (root,) = [one for one in SCHEMA["anyOf"] if one["$ref"].endswith(f"/{written['type']}")]
    assert faults(written, root) == []


def test_what_breaks_the_schema_is_found():
    curve = SCHEMA["$defs"]["Curve"]
    assert "$: no tau" in faults({"allanite": 1, "type": "Curve"}, curve)
    assert faults({"allanite": 2, "type": "Curve"}, {**curve, "required": []}) == ["$.allanite: 2 is not 1"]
    assert faults("absent", SCHEMA["$defs"]["Estimate"]["properties"]["status"]) == []
    assert faults("found", SCHEMA["$defs"]["Estimate"]["properties"]["status"])

"""What is typed or recorded wrongly is refused in a few plain words, and what the message says to type works."""

import gzip
import pickle
import re
import shlex
import zipfile

import numpy as np
import pytest
from tests.commands import run
from tests.rows import rows

import allanite as al

MOST, SENTENCE = 520, 255
"""Characters of a message with its table and the command to copy, and of its sentence.

A message is good if it says in one sentence what came, what was expected and what to do; the aim are 200 characters,
beyond which are only words of other libraries. A command that it shows works, and holds no unit or rate that nobody
stated.
"""

PYTHON = r"Traceback|\w+Error\b|Errno|[Ee]xception|\bNone\b|iterable|internal error|object has no|float\(\)|dict\b"
"""What no message says."""


def sentence(command, *answers, cure="", code=2):
    """A command in the folder of `files`, what is said of it, the command that cures it ("" if none is named), exit."""
    return command, answers, cure, code


MODEL = "'N 0.1 deg/sqrt(h)'"
SHORT = "deviation gyro.csv --no-intervals --channels gx"
ANALYZE = "analyze gyro.csv --channels gx"
THERMAL = "compensate gyro.csv -o new.params --regressors gz"
LINES = f"{ANALYZE} --method piecewise --terms NK --ranges"
PLAN = "plan --rate 100 --durations 600"

ROWS = [
    # commands and options
    sentence("analyse gyro.csv --help", "'analyse'", "did you mean analyze?", cure="analyze gyro.csv --help"),
    sentence("avar gyro.csv --help", "did you mean analyze?", cure="analyze gyro.csv --help"),
    sentence("xyzzy", "unknown command 'xyzzy'", "known commands: info, analyze"),
    sentence("info unit.csv --units deg/s", "did you mean --unit?", cure="info unit.csv --unit deg/s"),
    sentence("info bare.csv --unit deg/s --samplerate 10", "--rate?", cure="info bare.csv --unit deg/s --rate 10"),
    sentence("info gyro.csv --axis gx", "did you mean --channels?", cure="info gyro.csv --channels gx"),
    sentence("info gyro.csv --xyzzy", "unknown option '--xyzzy'", cure="info --help"),
    sentence("analyze gyro.csv -o x.html", "unknown option '-o'; did you mean --report?"),
    sentence("analyze gyro.csv --to kalibr", "kalibr is not a unit", "export does"),
    sentence("info gyro.csv --channels gx gy", "written with commas", cure="info gyro.csv --channels gx,gy"),
    sentence("spectrum gyro.csv --nperseg 64", "did you mean --segment?", cure="spectrum --help"),
    sentence("info", "Missing argument 'FILE'", cure="info --help"),
    sentence("simulate --sensor mems --rate 1 --samples 500 -o x.csv", "without an option",
             cure="simulate --sensor mems --rate 1 --samples 500 x.csv"),
    # units and rates
    sentence("info unit.csv", "unit is unknown", "gx [deg/s]", "try: allanite info unit.csv --unit"),
    sentence("info bare.csv", "rate is not in the file", "unit", "try: allanite info bare.csv --rate HZ --unit UNIT"),
    sentence("info bare.csv --rate HZ", "put the sampling rate in Hz in the place of HZ"),
    sentence("info rest.csv --rate 10", "looks like", "0.214 0.0095 gravity in m/s^2",
             cure="info rest.csv --rate 10 --unit 'm/s^2'"),
    sentence("info flagged.csv --rate 10", "1 0 0 constant", "--unit '2=m/s^2,3=m/s^2,4=m/s^2,1=UNIT'"),
    sentence("info accel.csv", "unit is unknown", cure="info accel.csv --unit g"),
    sentence("info six.csv", "unit is unknown", "try: allanite info six.csv --unit gyro=UNIT,accel=UNIT"),
    sentence("info unit.csv --unit deg/sec2", "'deg/sec2'", "did you mean deg/s?", cure="info unit.csv --unit deg/s"),
    sentence("info unit.csv --unit degs", "did you mean deg/s?", cure="info unit.csv --unit deg/s"),
    sentence("info unit.csv --unit furlong/s", "unknown unit 'furlong/s'", "units are written as deg/s"),
    sentence("info unit.csv --unit gyro=g", "'g' is not a unit of a gyro", "--unit gyro=deg/s,accel=g"),
    sentence("info gyro.csv --rate 100", "100.0 Hz", "10.0 Hz", cure="info gyro.csv --rate 100 --time none"),
    sentence("info millis.csv --rate 100", "10 Hz as ms", cure="info millis.csv --rate 100 --time none"),
    sentence("info gyro.csv --rate fast", "'--rate'", "expected a number, not 'fast'"),
    sentence("info gyro.csv --rate -5", "between 1e-09 and 1e+15 Hz", "-5"),
    sentence("info gyro.csv --kind rates", "did you mean rate?", cure="info gyro.csv --kind rate"),
    # columns, windows, levels
    sentence("info gyro.csv --channels gxx", "no column 'gxx'", "did you mean gx?", cure="info gyro.csv --channels gx"),
    sentence("info gyro.csv --channels gx,gx", "selected twice"),
    sentence("info gyro.csv --time tim", "no column 'tim'", "did you mean time?", cure="info gyro.csv --time time"),
    sentence("info gyro.csv --from 10min", "600 s", "from 0 s to 100 s"),
    sentence("info gyro.csv --until 1h", "ends at 3600 s", "100 s long"),
    sentence("info gyro.csv --from soon", "expected a time in s such as 600", cure="info gyro.csv --from 0.5min"),
    sentence("info gyro.csv --exclude 5", "pair of numbers in s, as 100..160"),
    sentence(f"{ANALYZE} --level 95", "not 95", "did you mean 0.95?", cure=f"{ANALYZE} --level 0.95"),
    sentence("analyze gyro.csv --band 1-10", "auto, all, or two frequencies", "not '1-10'"),
    sentence("analyze gyro.csv --band 5,1", "band", "low < high"),
    sentence("analyze gyro.csv --average 0.013", "0.013 s", "whole number of samples", "0.1 s"),
    sentence("analyze gyro.csv --average 3600", "means", "from 1 to 500", "36000"),
    sentence("analyze gyro.csv --ranges N=1:10", "ranges is for method 'piecewise'", "'whittle'"),
    sentence(f"{LINES} N=1:10,K=5:20", "N (1 to 10 s)", "K (5 to 20 s)", "overlap"),
    sentence(f"{LINES} N=10:1", "range of N", "lower one first"),
    sentence(f"{LINES} N=1,10", "N=0.1:10,K=100:1000", "'N=1,10'"),
    # names of tables
    sentence(f"{SHORT} --statistic avar", "did you mean oadev?", "square roots", cure=f"{SHORT} --statistic oadev"),
    sentence(f"{SHORT} --statistic=mvar", "did you mean mdev?", cure=f"{SHORT} --statistic=mdev"),
    sentence(f"{SHORT} --statistic xyz", "unknown statistic 'xyz'", "known statistics: adev, oadev"),
    sentence(f"{SHORT} --taus 1,10,5000", "up to 50 s", "not 5000 s", "--m", cure=f"{SHORT} --m 1,10,500"),
    sentence(f"{SHORT} --taus 0.05", "not a multiple of 0.1 s", cure=f"{SHORT} --taus 0.1"),
    sentence(f"{SHORT} --taus octaves", "did you mean octave?", "seconds", cure=f"{SHORT} --taus octave"),
    sentence(f"{SHORT} --m 1.5", "expected integers", "'1.5'"),
    sentence(f"{ANALYZE} --terms ARW,VRW,BI", "did you mean N?"),
    sentence(f"{ANALYZE} --terms ARW,BI", "did you mean N?", cure=f"{ANALYZE} --terms N,B"),
    sentence(f"{ANALYZE} --method mle", "did you mean whittle?", cure=f"{ANALYZE} --method whittle"),
    sentence(f"{ANALYZE} --device fogg", "did you mean fog?", cure=f"{ANALYZE} --device fog"),
    sentence("analyze gyro.csv --lang fr", "unknown language 'fr'", "en, ru, zh"),
    sentence("spectrum gyro.csv --window han", "did you mean hann?", cure="spectrum gyro.csv --window hann"),
    sentence("export gyro.csv --to openvin", "unknown target 'openvin'", "did you mean openvins?"),
    sentence("explain xyzzy", "unknown name 'xyzzy'; 'allanite explain' lists them"),
    sentence("explain vins", "did you mean vins-mono?", cure="explain vins-mono"),
    sentence("convert '0.1 deg/rt-hrr'", "did you mean deg/sqrt(h)?", cure="convert '0.1 deg/sqrt(h)'"),
    sentence("convert 0.1 'deg/sqrt(h)'", "one pair of quotes, as in '0.66 deg/sqrt(h)'"),
    sentence("convert '0.1 deg/h' --to kalibr --rate 9 --cover 300,1", "the shorter averaging time first"),
    sentence(f"{PLAN} --sensor memss", "did you mean mems?", cure=f"{PLAN} --sensor mems"),
    sentence(f"{PLAN} --model 'ARW 0.1 deg/sqrt(h)'", "did you mean N?", cure=f"{PLAN} --model {MODEL}"),
    sentence(PLAN, "or the noise with --model, --sensor or --datasheet", cure=f"{PLAN} --model {MODEL}"),
    sentence(f"{PLAN} --datasheet adis1647", "did you mean ADIS16470?", cure=f"{PLAN} --datasheet ADIS16470"),
    sentence(f"{PLAN} --datasheet adis16470 --sensor fog", "given twice", "use only one of --model, --sensor or"),
    sentence("compare gyro.csv gyro.csv --datasheet adis16470", "a single file with a data sheet"),
    sentence("plan --sensor mems", "sampling rate", "--rate HZ"),
    sentence("drift", "give the noise", "--model, --sensor or --datasheet", "--require '1 deg in 10 min'"),
    sentence("drift --sensor mems --require '1 deg'", "'1 deg in 10 min' or '100 m in 1 min', not '1 deg'"),
    sentence("drift --sensor mems --claims imu.yml", "'imu.yml' cannot be read", code=3),
    sentence("drift --sensor mems --scale-factor 1", "below 0.1, not 1", "did you mean 0.01?"),
    sentence("drift --sensor mems --turn 90deg", "did you mean --maneuver?"),
    sentence("vertical six.csv --filter kalmann", "did you mean kalman?"),
    sentence("rate gyro.csv --interval 99999", "longer than the record of 100 s", cure="rate gyro.csv --interval 10"),
    sentence("dynamic gyro.csv --window 99999", "99999 s is not possible", "100 s long"),
    sentence("compensate gyro.csv --regressors temp", "no column 'temp'", "gx [deg/s]"),
    sentence("compensate gyro.csv --regressors gz --to px4", "--to px4 writes a file", "--output PATH"),
    sentence("compensate gyro.csv --regressors gz -o x", "for the parameters of an autopilot", "add --to px4"),
    sentence(f"{THERMAL} --to pixhawk", "unknown autopilot 'pixhawk'", "px4, ardupilot"),
    sentence(f"{THERMAL} --to px4 --degree 5", "powers up to 3, not 5: --degree 3"),
    sentence(f"{THERMAL} --to px4 --instance 4", "numbers its sensors from 0 to 3"),
    sentence(f"{THERMAL},gy --to ardupilot", "the powers of one temperature, not gy as well", "--regressors temp"),
    sentence("export gyro.csv --channels gx --to kalibr --unexplained", "needs an accelerometer", "--model", code=3),
    sentence(f"simulate new.csv --model {MODEL} --rate 10 --duration 5x", "'10 min' or 1h, not '5x'"),
    sentence(f"simulate new.foo --model {MODEL} --rate 10 --duration 9", "'.foo'", ".csv, .npz"),
    # recipes and limits
    sentence("info gyro.csv --recipe absent.toml", "'absent.toml'", "No such file"),
    sentence("info gyro.csv --recipe folder", "'folder' is not a regular file"),
    sentence("info gyro.csv --recipe broken.toml", "cannot be read as TOML", "line 1"),
    sentence("analyze gyro.csv --recipe limits.toml", "limits: expected a path"),
    sentence("info gyro.csv --recipe rate.toml", "rate: expected a number, not [1, 2]"),
    sentence("analyze gyro.csv --recipe about.toml", "about: expected text, a list of texts, or a table, not 5"),
    sentence("analyze gyro.csv --recipe flag.toml", "unexplained", "known keys"),
    sentence("info gyro.csv --recipe key.toml", "unknown key 'samplerate'", "did you mean rate?"),
    sentence("analyze gyro.csv --recipe out.toml", "'report' is no key of a recipe", "--report"),
    sentence("analyze gyro.csv --limits absent.toml", "the limits file 'absent.toml'", "No such file"),
    sentence("analyze gyro.csv --limits symbol.toml", "unknown term 'ARW' in [limits]", "did you mean N?"),
    sentence("analyze gyro.csv --limits wrong.toml", "0.15 deg/sqrt(h)", "with the unit"),
    sentence("analyze gyro.csv --limits 'N < 0.15'", "the limit of N", "with a unit"),
    sentence("analyze gyro.csv --limits bare.toml", "N stands below no heading; write [limits]"),
    # files
    sentence("info x.pdf", "a PDF, not a recording", code=3),
    sentence("info https://example.com/x.csv", "an address: download it first", code=3),
    sentence("info gyro.csv --time gx", "is a signal, not time", code=3),
    sentence("compare gyro.csv still.csv", "gx / ax, gy / ay, gz / az: only sensors of one type", code=3),
    sentence("info absent.csv", "absent.csv: no such file", "check the name", code=3),
    sentence("info folder", "this is a directory", code=3),
    sentence("info empty.csv", "the file is empty", code=3),
    sentence("info word.csv", "line 51", "'gx [deg/s]'", "'oops' is not a number", code=3),
    sentence("info stuck.csv", "all time stamps", "are equal", "try: allanite info stuck.csv --rate HZ"),
    *(
        sentence(f"info cut{suffix}", "cut", "damaged|incomplete|cut off|not complete", code=3)
        for suffix in (".npy", ".npz", ".parquet", ".h5", ".mat", ".csv.gz", ".csv.xz", ".csv.bz2", ".zip")
    ),
    sentence("export cut.json --to datasheet", "cut.json is damaged", "write the result again", code=3),
    sentence("export part.json --to datasheet", "part.json is no complete result", "write it again", code=3),
    sentence("export list.json --to datasheet", "list.json", "without a type", code=3),
    # outputs
    sentence("info gyro.csv --json taken.json", "already exists", cure="info gyro.csv --json taken.json --force"),
    sentence("info gyro.csv --json gyro.csv --force", "would overwrite the input"),
    sentence("analyze gyro.csv --csv a.txt --json a.txt", "would overwrite --json"),
    sentence("info gyro.csv --json absent/x.json", "the folder 'absent'", "does not exist"),
    sentence("info gyro.csv --report folder", "is a folder"),
    sentence("info gyro.csv --report x.docx", ".html or .pdf"),
    sentence("analyze gyro.csv --plot x.foo", "png, svg, pdf", "'foo'"),
    sentence("analyze gyro.csv --json - --csv -", "only one result"),
    sentence("info gyro.csv --threads 1.5", "expected a number of processors, at least 1, or auto, not '1.5'"),
    sentence("lot folder", "does not hold the results", "make one with allanite batch FOLDER --out 'folder'"),
    sentence("batch absent --out results", "'absent'", "No such file"),
]  # fmt: skip


def table(header, *columns):
    rows = (",".join(f"{x:.10g}" for x in row) for row in zip(*columns, strict=True))
    return "\n".join((header, *rows, ""))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Recordings of 100 s at 10 Hz, and files that are wrong in one way each."""
    folder, x = tmp_path_factory.mktemp("errors"), 0.01 * np.random.default_rng(3).normal(size=(3, 1000))
    t = np.arange(1000) / 10
    gyro = table("time [s],gx [deg/s],gy [deg/s],gz [deg/s]", t, *x)
    texts = {
        "gyro.csv": gyro,
        "unit.csv": table("time,gx,gy,gz", t, *x),
        "bare.csv": table("1,2,3", *x),
        "rest.csv": table("1,2,3", x[0], x[1], 9.76 + x[2]),
        "flagged.csv": table("1,2,3,4", np.ones(1000), x[0], x[1], 9.76 + x[2]),
        "accel.csv": table("time,accel_x,accel_y,accel_z", t, x[0] + 0.6, x[1], x[2] - 0.8),
        "six.csv": table("time,gx,gy,gz,ax,ay,az", t, *x, *x),
        "millis.csv": table("stamp,gx [deg/s]", 1000 * t, x[0]),
        "stuck.csv": table("time [s],gx [deg/s]", 0 * t + 5, x[0]),
        "word.csv": table("time [s],gx [deg/s]", t[:49], x[0][:49]) + "4.9,oops\n" + "5.0,0.1\n",
        "still.csv": table("time [s],ax [g],ay [g],az [g]", t, *x), "x.pdf": "%PDF-1.4", "bare.toml": "N = '1 deg/h'\n",
        "empty.csv": "", "cut.json": "{", "part.json": '{"type": "Study"}', "list.json": "[1]", "taken.json": "mine",
        "broken.toml": "rate =\n", "limits.toml": "[limits]\nN = 1\n", "rate.toml": "rate = [1, 2]\n",
        "about.toml": "about = 5\n", "flag.toml": "unexplained = true\n", "key.toml": "samplerate = 10\n",
        "out.toml": "report = 'x.html'\n", "symbol.toml": "[limits]\nARW = '1 deg/sqrt(h)'\n",
        "wrong.toml": "[limits]\nN = '1 deg/h'\n",
    }  # fmt: skip
    for name, text in texts.items():
        (folder / name).write_text(text)
    (folder / "folder").mkdir()
    record = al.Record(x[0], rate=10.0, unit="deg/s", name="gx")
    for suffix in (".npz", ".parquet", ".h5", ".mat"):
        al.write(record, folder / f"cut{suffix}")
    np.save(folder / "cut.npy", x)
    for suffix, pack in ((".gz", gzip), (".xz", pytest.importorskip("lzma")), (".bz2", pytest.importorskip("bz2"))):
        (folder / f"cut.csv{suffix}").write_bytes(pack.compress(gyro.encode()))
    with zipfile.ZipFile(folder / "cut.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("gyro.csv", gyro)
    for path in folder.glob("cut.[!j]*"):
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    return folder


@rows("row", ROWS, ids=lambda row: row[0])
def test_what_is_wrong_is_said_in_a_few_words_with_what_to_type(row, files, monkeypatch):
    command, answers, cure, code = row
    monkeypatch.chdir(files)
    result = run(*shlex.split(command), code=code)
    assert (result.stdout, type(result.exception)) == ("", SystemExit)
    assert result.stderr.startswith("error: ")
    said = " ".join(result.stderr.split())
    for word in answers:
        assert re.search(word, said) if "|" in word else word in said, said
    assert not re.search(PYTHON, said), said
    assert len(said) <= MOST, said
    assert len(result.stderr.splitlines()[0]) <= SENTENCE, said
    if cure:
        typed = re.search(r"try: allanite (.*)", result.stderr)
        assert typed is None or typed[1] == cure
        run(*shlex.split(cure), code=0)


def test_a_recipe_may_hold_names_of_options_and_a_table_of_facts(files, monkeypatch):
    monkeypatch.chdir(files)
    (files / "good.toml").write_text('from = "0.5 min"\n[about]\nserial = "SN 7"\n')
    shown = run("analyze", "gyro.csv", "--recipe", "good.toml", "--json", "-", "--channels", "gx", code=0).stdout
    assert ('"start": 30.0' in shown, "serial=SN 7" in shown) == (True, True)
    assert al.Recipe.from_dict({"from": 30.0}).start == 30.0


def test_the_same_refusal_in_python_and_at_the_command_line(tmp_path):
    file = tmp_path / "x.csv"
    file.write_text("gx [deg/s]\n" + "1.5\n2.5\n" * 200)
    with pytest.raises(al.UsageError, match="rate=100") as refused:
        al.read(file)
    assert "--rate" not in str(refused.value)
    said = run("info", file).stderr
    assert ("--rate HZ" in said, "rate=100" in said) == (True, False)


def test_an_error_keeps_its_code_where_it_is_named_and_in_a_pickle():
    error = pickle.loads(pickle.dumps(al.DataError("too loud", code="moving").within("a.csv")))
    assert (type(error), str(error), error.code) == (al.DataError, "a.csv: too loud", "moving")

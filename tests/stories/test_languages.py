"""Nothing that is shown stays English: every result in letters that are not Latin, and the words left over."""

import re
import shlex
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.text import Text

import allanite as al
from allanite.applications.attitude import FILTERS
from allanite.applications.constant_rate import RATE_ESTIMATORS
from allanite.cli import VERBS, deliver, main
from allanite.core.errors import UndrawnError
from allanite.exporting.exports import EXPORTS, TEMPERATURE
from allanite.identification.methods import METHODS
from allanite.parallel.sharing import Work, made
from allanite.phrases.phrase import Phrase
from allanite.reporting import html, language, text
from allanite.reporting.sheet import Code, Fold
from allanite.reporting.sketch.limits import Unsketched
from allanite.reporting.views import level_of, view_of
from allanite.statistics import STATISTICS
from allanite.terms import TERMS

pytestmark = pytest.mark.slow("what every verb shows, in other letters: releases ask for translations")

LETTERS = {ord(latin): ord("а") + i for i, latin in enumerate("abcdefghijklmnopqrstuvwxyz")}
LETTERS |= {ord(chr(latin).upper()): ord(chr(other).upper()) for latin, other in LETTERS.items()}
FIELD = re.compile(r"(\{\{|\}\}|\{[^{}]*\})")


class Pseudo:
    """A catalogue that has every template, in letters that are not Latin."""

    def gettext(self, message):
        """The template with its fields."""
        parts = FIELD.split(message)
        parts[::2] = [part.translate(LETTERS) for part in parts[::2]]
        return "".join(parts)

    def ngettext(self, one, many, count):
        """The same of a number."""
        return self.gettext(one if count == 1 else many)


DATA = [
    r"(?<![\w-])--[a-z][\w-]*(=\S+)?",  # options
    r"\ballanite \w+ .*?(?=[;:)]|\s\s|$)",  # commands
    r"\ballanite\b|\bsha256\b|\b[0-9a-f]{12,}\b|\.dev\w+",  # the program, digests
    r"(?<!\w)/\S+|\b[\w-]+\.(csv|toml|json|html|npz|py)\b",  # files
    r"\b(al|prepare|planning)\.\w+(\.\w+)*(\([^)]*\))?",  # calls
    r"\b(ISO|IEEE|IEC|NIST|RFC|PDF|CSV|JSON|TOML|DCT-II|Std|SP) ?[\d-]*",  # standards and formats
    r"'time \[s\]'",  # a column
    rf"^({'|'.join(FILTERS)})$",  # the name of a filter in a cell
    r"imu = \S.*|config = \S.*",  # notes that are code
    *(re.escape(row.reference) for row in FILTERS.values() if not isinstance(row.reference, Phrase)),
]
"""What is no word of a sentence."""

FIELDS = {field.full for row in EXPORTS.values() for field in row.fields}
FIELDS |= {part for name in FIELDS for part in (name.split(".")[-1], f"{name.split('.')[0]}.")}
KNOWN = sorted(FIELDS | {*EXPORTS, *STATISTICS} | {row.name for row in TEMPERATURE.values()}, key=len, reverse=True)
DATA.append(rf"(?<![\w.])({'|'.join(map(re.escape, KNOWN))})(?!\w)")

QUOTED = {text for sheet in al.DATASHEETS.values() for text in (sheet.name, sheet.maker, sheet.document)}
QUOTED |= {text for c in al.DATASHEETS["ADIS16470"].claims for text in (c.printed, c.conditions, c.place)}
DATA += sorted((rf"(?<!\w){re.escape(text)}(?!\w)" for text in QUOTED), key=len, reverse=True)

UNITS = "deg rad arcsec sqrt Hz kHz min mGal ug mg ms degC ppm rms LSB bit nT mV uV mA uA Nm kg"
SYMBOLS = "beta GM ARW VRW RRW tau edf dof chi AIC ADC DAC Phi Qd"
NAMES = "adis gx gy gz ay ux temp enc ref h_polar q_polar offset ax az fog mems hann python operator arXiv Shupe Zhuo"
CODES = {"ru", "zh", "en"}


def allowed():
    """Words of Latin letters that are names, units or symbols."""
    known = {*UNITS.split(), *SYMBOLS.split(), *NAMES.split(), *CODES, *TERMS, *STATISTICS, *METHODS, *RATE_ESTIMATORS}
    known |= {"bortz", "madgwick", "mahony"}
    return known | {p.letter or p.name for row in TERMS.values() for p in row.parameters}


def left(shown: Iterable[str]) -> list[str]:
    """Lines with words that are still English, each with these words before it."""
    known, found = allowed(), {}
    for line in shown:
        rest = re.sub("|".join(DATA), " ", line)
        words = [word for word in re.findall(r"[A-Za-z]{2,}", rest) if word not in known]
        if words:
            found.setdefault(" ".join(dict.fromkeys(words)), " ".join(line.split())[:160])
    return [f"{words}   <- {line}" for words, line in found.items()]


class Shown(HTMLParser):
    """What a reader of a page sees or hears, without code and styles."""

    def __init__(self, page):
        super().__init__()
        self.texts, self.inside = [], []
        self.feed(re.sub(r'<span class="option">(.*?)</span>', r"\1", page))  # parts of a sentence

    def handle_starttag(self, tag, attrs):
        """Collect titles and labels."""
        if tag in ("style", "pre", "code", "math"):
            self.inside.append(tag)
        self.texts += [value or "" for name, value in attrs if name in ("aria-label", "title", "alt", "data-label")]

    def handle_endtag(self, tag):
        """Leave code."""
        if self.inside and self.inside[-1] == tag:
            self.inside.pop()

    def handle_data(self, data):
        """Collect text."""
        if not self.inside:
            self.texts.append(data)


def without_code(parts):
    """The same parts with nothing that is to be copied into a program."""
    kept = [replace(part, parts=without_code(part.parts)) if isinstance(part, Fold) else part for part in parts]
    return [replace(part, text="") if isinstance(part, Code) else part for part in kept]


def words_of(figure):
    """The texts of a figure."""
    return [artist.get_text() for artist in figure.findobj(Text)]


def shown(value, monkeypatch, drawn, lang="xx"):
    """Everything that terminal, page and figures show of a value; `drawn`: it has a figure for print."""
    level, found = level_of(value), []
    with language.speaking(lang):
        face = view_of(value).face(value, level)
        sheets = [replace(sheet, parts=without_code(sheet.parts)) for sheet in face.sheets]
        parts = {name: without_code(getattr(face, name)) for name in ("parts", "close", "how")}
        face = replace(face, sheets=sheets, choices="", **parts)
        found += text.render(face).splitlines()
        monkeypatch.setattr(html, "drawn", lambda drawing, lang: found.extend(words_of(drawing.draw().printed())))
        monkeypatch.setattr(html, "drawer", lambda pictures: lambda drawing: "")
        found += Shown(made(html.render(replace(face, command="allanite"), Work.one(lambda: b"x")))).texts
        found += [html.tr(drawn.label) for drawn in drawings(face)]
    if drawn and view_of(value).plot is not None:
        with suppress(UndrawnError):  # such as a file that holds the whole model
            found += words_of(al.plot(value, lang=lang))
    return found


def drawings(face):
    """The figures of a page, in its folds too."""
    pile = [*face.parts, *face.close, *face.how, *(part for sheet in face.sheets for part in sheet.parts)]
    while pile:
        part = pile.pop()
        pile += part.parts if isinstance(part, Fold) else ()
        if hasattr(part, "label"):
            yield part


def recording(path, seed, n=2000, **more):
    """A gyroscope at 20 Hz."""
    rng = np.random.default_rng(seed)
    model = al.N(0.1, "deg/sqrt(h)") + al.K(20.0, "deg/h/sqrt(h)")
    rate = np.degrees(al.simulate(model, n, 20.0, rng=rng).values) * 3600
    temp = 25 + 5 * np.sin(np.arange(n) / 300) + 0.02 * rng.standard_normal(n)
    columns = {"time [s]": np.arange(n) / 20.0, "gx [deg/h]": rate + 3 * temp, "temp [degC]": temp, **more}
    head = ",".join(columns)
    np.savetxt(path, np.column_stack(list(columns.values())), "%.9g", ",", header=head, comments="")
    return path


def six(path, n=4000, rate=20.0):
    """Three gyros and three accelerometers at rest."""
    rng = np.random.default_rng(5)
    gyro = al.N(0.3, "deg/sqrt(h)") + al.K(300.0, "deg/h/sqrt(h)")
    gyros = [np.degrees(al.simulate(gyro, n, rate, rng=rng).values) for _ in range(3)]
    tilts = [al.simulate(al.N(100, "ug/sqrt(Hz)"), n, rate, rng=rng).values for _ in range(3)]
    columns = np.column_stack([np.arange(n) / rate, *gyros, *tilts[:2], tilts[2] + 9.80665])
    head = "time [s],gx [deg/s],gy [deg/s],gz [deg/s],ax [m/s^2],ay [m/s^2],az [m/s^2]"
    np.savetxt(path, columns, "%.9g", ",", header=head, comments="")
    return path


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Small inputs, by name."""
    folder = tmp_path_factory.mktemp("in")
    rng = np.random.default_rng(3)
    found = {"a": recording(folder / "a.csv", 1), "b": recording(folder / "b.csv", 2)}
    found["short"] = recording(folder / "short.csv", 3, n=40)
    wild = {"gy [deg/h]": 90 * rng.standard_normal(2000).cumsum(), "gz [deg/h]": np.zeros(2000)}
    found["wild"] = recording(folder / "wild.csv", 4, **wild)
    found["limits"] = folder / "limits.toml"
    found["limits"].write_text('[limits]\nN = { max = "0.01 deg/sqrt(h)" }\nB = { max = "90 deg/h" }\n')
    volts = np.round(rng.standard_normal(4000) * 100) * 0.01
    found["current"] = folder / "current.csv"
    np.savetxt(found["current"], np.column_stack([np.arange(4000) / 1000, volts]), "%.9g", ",",
               header="time [s],ux [V]", comments="")  # fmt: skip
    true = np.linspace(0, 12.5, 2000)
    measured = true + 1e-4 * np.sin(128 * true) + 1e-5 * rng.standard_normal(2000)
    found["encoder"] = folder / "encoder.csv"
    np.savetxt(found["encoder"], np.degrees(np.column_stack([measured, true])), "%.10g", ",",
               header="enc [deg],ref [deg]", comments="")  # fmt: skip
    found["six"], found["kalibr"] = six(folder / "six.csv"), folder / "imu.yaml"
    run("convert '1 deg/sqrt(h)' 'K 9 deg/h/sqrt(h)' '90 ug/sqrt(Hz)' 'K 10 ug/sqrt(h)' --to kalibr --rate 100 "
        "-o {kalibr}", found)  # fmt: skip
    found["lot"] = lot(folder, found)
    found["hour"], found["made"] = folder / "hour.csv", folder / "made.csv"
    run("angle simulate {hour} --latitude 60 --duration 3600 --start 7200 --error h:128=3,-1.5", found)
    return found


def lot(folder, files):
    """Stored results of eight units, of which one is noisy and one too short."""
    lines = ["file,temperature,date"]
    for i, size in enumerate((0.1, 0.11, 0.12, 0.13, 0.14, 5.0)):
        record = al.simulate(al.N(size, "deg/sqrt(h)"), 2000, 20.0, rng=np.random.default_rng(i), name="gx")
        al.write(record, folder / f"unit{i}.csv")
        lines.append(f"unit{i}.csv,{20 + i},2024-05-{10 + i}")
    (folder / "units.csv").write_text("\n".join([*lines, "a.csv,,", "short.csv,,"]) + "\n")
    run(f"batch {folder / 'units.csv'} --out {folder / 'lot'} --workers 1 --channels gx", files)
    return folder / "lot"


TORQUER = "turns=100,field=0.4,span=0.05,radius=0.05,inertia=2e-3,spin=1000,sides=4"
GIVEN = "--model 'N 0.3 deg/sqrt(h), K 10 deg/h/sqrt(h)' --model 'N 100 ug/sqrt(Hz), K 50 ug/sqrt(h)'"
NOISE = "--gyro 'N 0.3 deg/sqrt(h), B 10 deg/h' --accelerometer 'N 100 ug/sqrt(Hz), B 50 ug'"
RUNS = {
    "info": ["{a}", "{short}", "{wild}"],
    "analyze": [
        "{a} --channels gx --device fog --about operator=x", "{wild} --channels gx,gy,gz",
        "{a} --channels gx --method slopes", "{a} {b} --channels gx --limits {limits}",
        "{a} {b} --channels gx --device fog",
    ],
    "lot": ["{lot}", "{lot} --limits {limits}"],
    "deviation": ["{a} --channels gx --statistic oadev,hdev"],
    "spectrum": ["{a} --channels gx"],
    "dynamic": ["{a} --channels gx"],
    "compare": [
        "{a} {b} --channels gx", "{a} {b} {wild} --channels gx", "{a} --channels gx --part 60",
        "{a} --channels gx --datasheet adis16470",
    ],
    "check": [
        "{six} --claims 'N 0.3 deg/sqrt(h), K 20 deg/h/sqrt(h); 60 ug/sqrt(Hz)'", "{a} --channels gx --claims {limits}",
        "{six} --claims adis16470", "{a} --channels gx --claims 'N 1 deg/sqrt(h), GM 30 deg/h 20 s, R 3 deg/h^2'",
    ],
    "watch": ["{a} --channels gx --idle 0.1"],
    "rate": ["{a} --channels gx --interval 20"],
    "angle": [
        "calibrate {encoder} --measured enc --reference ref",
        "estimate {hour} --difference difference --latitude 60 --rho rho",
        "plan --latitude 60 --duration 3600", "plan --latitude 60 --duration 3600 --start 0",
    ],
    "simulate": ["{made} --sensor mems --rate 20 --samples 2000 --force"],
    "plan": ["--sensor fog --rate 10", "{a} --channels gx"],
    "drift": [
        "--sensor fog --require '1 deg in 10 min'", "{six} --from-curve", GIVEN + " --times 3600 --turn-on '9 deg/h'",
        "{a} --channels gx --calibration 0 --platform level",
    ],
    "selfcheck": ["--sensor mems --rate 20 --samples 1000 --records 3"],
    "statespace": ["--sensor fog --rate 10"],
    "export": [
        "{six} --to vins-mono", "{six} --to gazebo --axis each --inflate 2", "{wild} {six} --to kalibr --unexplained",
        "{six} --to datasheet", "--to px4 " + GIVEN, "{six} --to statespace",
    ],
    "convert": ["'1 deg/sqrt(h)' --to gtsam", "{kalibr} --from kalibr", "{kalibr} --from kalibr --to vins-mono"],
    "explain": ["", *EXPORTS, "px4-tc", "theo1", "hdev --samples 100", "adis16470"],
    "budget": ["{current} --unit V {stage} --torquer " + TORQUER + " --sense 5"],
    "compensate": ["{a} --regressors temp --channels gx", "{a} --regressors temp --to px4 -o {a}.params --force"],
    "vertical": [
        "{six}", "{six} --filter bortz", "{six} --filter kalman --time-constant 5 --keep-bias",
        NOISE + " --gyro-bias '10 deg/h'", NOISE + " --scenarios --rate 10", "{six} --gate 0.001",
    ],
}  # fmt: skip
"""Arguments of each verb, which between them show most of what it can say."""


def run(line, files):
    """Run a command line."""
    words = [word.format(**files, stage="--stage=ADC 12 5V") for word in shlex.split(line)]
    done = CliRunner().invoke(main, words)
    assert done.exit_code in (0, 3, 4, 5), (line, done.output)
    return done


@pytest.fixture
def pseudo(monkeypatch):
    """The language "xx"."""
    one = Pseudo()
    monkeypatch.setattr(
        language, "catalogue", lambda lang: one if lang == "xx" else language.gettext.NullTranslations()
    )


def test_every_verb_is_run():
    # example runs the others, batch shows nothing
    assert {verb for verb in VERBS if verb not in ("example", "batch", "serve")} == set(RUNS)


@pytest.fixture(scope="module", params=RUNS)
def verb(request):
    """A verb; the tests of one come one after the other."""
    return request.param


@pytest.fixture(scope="module")
def values(verb, files):
    """What a verb shows, without names of papers."""
    found = []
    with pytest.MonkeyPatch.context() as patch:
        for table, name, row in [(t, *item) for t in (EXPORTS, TEMPERATURE) for item in t.items()]:
            patch.setitem(table, name, replace(row, source=""))
        if verb == "explain":
            for name, statistic in STATISTICS.items():
                patch.setitem(STATISTICS, name, replace(statistic, reference=""))
        patch.setattr(deliver, "text_of", lambda value, *_: found.append(value) or "")
        for line in RUNS[verb]:
            run(f"{verb} {line}", files)
        assert len(found) == len(RUNS[verb])
        yield found


def test_nothing_that_a_verb_shows_is_left_in_english(verb, values, pseudo, monkeypatch):
    found = left(
        part
        for one, line in zip(values, RUNS[verb], strict=True)
        for part in shown(one, monkeypatch, verb != "info" and "--start" not in line)
    )
    assert not found, f"{verb}: {len(found)} lines have words that are not translated:\n" + "\n".join(found)


PLAIN = r"(?<!\w)(deg(?!C)|ug|sqrt\((h|s|Hz)\))(?!\w)"
"""Units as they are typed."""

TYPED = r"(?<!\w)'[^']*'(?!\w)|\"[^\"]*\"|--\S+ \S+|^(time|enc|ref|g[xyz]|a[xyz]) \[.*"
"""Where they may be."""


@pytest.mark.parametrize("lang", language.LANGUAGES)
@pytest.mark.filterwarnings("ignore::allanite.reporting.fonts.FontWarning")
def test_units_are_shown_with_their_signs(verb, values, lang, monkeypatch):
    found = [
        line
        for one in values
        for line in shown(one, monkeypatch, drawn=False, lang=lang)
        if re.search(PLAIN, re.sub(TYPED, "", line))
    ]
    assert not found, "\n".join(found)


def test_a_terminal_without_signs_has_letters_of_ascii(verb, values):
    for one in values:
        face = view_of(one).face(one, level_of(one))
        odd = [line for line in text.render(face, ascii=True).splitlines() if not line.isascii()]
        assert not odd, "\n".join(odd)


def printed_words(figure):
    """Lines of titles, names, labels and legends of a figure of matplotlib, without those at ticks."""
    panels = [axes for axes in figure.axes if axes.get_visible()]
    sides = [side for axes in panels for side in (axes.xaxis, axes.yaxis)]
    ticks = {id(text) for side in sides for text in (*side.get_ticklabels(), *side.get_ticklabels(minor=True))}
    hidden = {id(text) for axes in panels if not axes.axison for text in axes.findobj(Text)}
    hidden |= {
        id(side.label) for axes in panels for side in [axes.xaxis] if not axes.xaxis.get_tick_params()["labelbottom"]
    }
    texts = [text for text in figure.findobj(Text) if id(text) not in ticks | hidden and text.get_visible()]
    return {line.strip() for text in texts for line in text.get_text().splitlines()} - {""}


def test_a_figure_on_a_page_has_the_words_of_that_for_print(verb, values):
    for value in values:
        for drawing in drawings(view_of(value).face(value, level_of(value))):
            try:
                page = ElementTree.fromstring(drawing.draw().sketched().svg())
            except Unsketched:
                continue
            wide, high = (float(number) for number in page.get("viewBox").split()[2:])
            texts = list(page.iter("{http://www.w3.org/2000/svg}text"))
            assert all(0 <= float(t.get("x")) <= wide and 0 <= float(t.get("y")) <= high for t in texts)
            said = {" ".join(text.text.split()) for text in texts}
            printed = {" ".join(line.split()) for line in printed_words(drawing.draw().printed())}
            assert printed - said <= {line for line in printed if "$" in line}, verb

"""The documentation site: it is built without a warning, and has a page for every row and word."""

import json
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest
from tests import ROOT

import allanite as al
from allanite.cli import VERBS
from allanite.core.units import ATOMS, SPELLINGS

pytestmark = pytest.mark.nightly("builds the documentation site, as docs.yml does on the main branch")

DOCS = ROOT / "docs"
SAMPLE = Path("examples", "tactical_gyro.csv")
RESULTS = Path("benchmarks", "results")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, built from a copy, so that nothing is written into the checkout."""
    pytest.importorskip("sphinx", reason="the documentation's tools are not installed here")
    place = tmp_path_factory.mktemp("docs")
    shutil.copytree(DOCS, place / "docs", ignore=shutil.ignore_patterns("generated"))
    (place / "examples").mkdir()
    shutil.copy(ROOT / SAMPLE, place / SAMPLE)
    shutil.copytree(ROOT / RESULTS, place / RESULTS)
    shutil.copytree(ROOT / "tests" / "plugin", place / "tests" / "plugin")  # shown by the page on plug-ins
    shutil.copy(ROOT / "CHANGELOG.md", place)
    build = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", "docs", "site"]
    done = subprocess.run(build, cwd=place, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return place / "site"


def text(site, page):
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", (site / page).read_text("utf-8")))


def test_every_row_has_its_page(site):
    for symbol, row in al.terms.TERMS.items():
        page = text(site, f"generated/terms/{symbol}.html")
        assert row.title in page
        assert row.reference.split(";")[0] in page  # the generator adds editions behind the number of a standard
    for name, row in al.statistics.STATISTICS.items():
        page = text(site, f"generated/statistics/{name}.html")
        assert (row.title in page, "longest τ" in page) == (True, True), name
        assert (site / "_images" / f"{name}.svg").stat().st_size > 5000
    for index, table in (("terms", al.terms.TERMS), ("statistics", al.statistics.STATISTICS)):
        assert all(row.title in text(site, f"generated/{index}/index.html") for row in table.values())


def test_every_verb_and_public_name_is_there(site):
    command = text(site, "command.html")
    names = "".join(page.read_text("utf-8") for page in (site / "generated/api").glob("*.html"))
    assert [name for name in VERBS if f"Usage: allanite {name} [OPTIONS]" not in command] == []
    wanted = [name for name in dir(al) if not name.startswith("_") and callable(getattr(al, name))]
    for package in ("angle", "constant_rate", "simulation.faults", "prepare", "statistics", "compensation"):
        wanted += [f"{package}.{name}" for name in public_names(package)]
    assert [name for name in wanted if f'id="allanite.{name}"' not in names] == []


def public_names(package):
    """What the page of a package says that it offers."""
    sys.path.insert(0, str(DOCS))
    try:
        from generate.api import public_names as names
    finally:
        sys.path.pop(0)
    found = names(package)
    assert len(found) >= 3
    return found


def test_methods_units_and_formulas(site):
    formulas = (site / "generated/statistics/oadev.html").read_text("utf-8")
    assert ("<math " in formulas, "<munderover>" in formulas, "MathJax" in formulas) == (True, True, False)
    page = text(site, "methods.html")
    for name, row in al.identification.METHODS.items():
        assert page.count(f" {name} ") >= 5
        assert row.efficiency in page
    assert (site / "_images" / "methods.svg").stat().st_size > 5000
    page = text(site, "generated/units.html")
    for name in (*ATOMS, *SPELLINGS):
        assert f" {name} " in page
    assert "0.000290888" in page


class Links(HTMLParser):
    def __init__(self):
        super().__init__()
        self.loaded, self.led = [], []

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        if tag in ("script", "img", "iframe") and "src" in found:
            self.loaded.append(found["src"])
        if tag == "link" and found.get("rel") in ("stylesheet", "preload", "icon"):
            self.loaded.append(found["href"])
        if tag == "a" and "href" in found:
            self.led.append(found["href"])


def test_nothing_is_loaded_from_a_network_and_every_link_leads_somewhere(site):
    for page in site.rglob("*.html"):
        links = Links()
        links.feed(page.read_text("utf-8"))
        assert not [url for url in links.loaded if "//" in url], page
        inner = [url.split("#")[0].split("?")[0] for url in (*links.loaded, *links.led) if "//" not in url]
        assert not [url for url in inner if url and not (page.parent / url).exists()], page


WORDS = (
    "ARW VRW RRW ADEV OADEV MDEV TDEV HDEV OHDEV TOTDEV MTOTDEV TTOTDEV HTOTDEV PDEV MTIE AVAR DAVAR EDF PSD ASD LSB "
    "GM BI TheoH flicker kalibr imu.yaml run bias stability noise density citation confidence interval angle random "
    "walk allantools quantization RMS fs"
)
"""What engineers look for; the search leaves out "in"."""


def test_the_search_knows_the_fields_words(site):
    stem = pytest.importorskip("snowballstemmer").stemmer("porter").stemWord
    text = (site / "searchindex.js").read_text("utf-8")
    index = json.loads(text[text.index("(") + 1 : text.rindex(")")])
    known = set(index["terms"]) | set(index["titleterms"])
    assert [word for word in re.findall(r"\w+", WORDS.lower()) if not {stem(word), word} & known] == []

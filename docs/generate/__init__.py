"""Pages that are read off the package: a page a noise term, a page a statistic, units, options, Python names."""

import shutil
from collections.abc import Iterable
from pathlib import Path

from sphinx.application import Sphinx

from allanite.statistics import STATISTICS
from allanite.terms import TERMS
from generate.api import api_pages
from generate.benchmarks import benchmark_pages
from generate.data_sheets import compared_page, data_sheets_page, quantities_table
from generate.devices import devices_page
from generate.exports import exports_page
from generate.gallery import gallery_page
from generate.methods import efficiencies, methods_page
from generate.planning import accuracies
from generate.recordings import recordings_page
from generate.reference import help_pages, units_page
from generate.slopes import slopes_figure
from generate.statistics import statistic_index, statistic_page
from generate.terms import term_index, term_page
from generate.tutorial import beside, run_tutorial

RESULTS = Path("benchmarks", "results", "methods.md")


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages before Sphinx looks for them."""
    app.connect("builder-inited", lambda app: write_pages(Path(app.srcdir)))
    return {"parallel_read_safe": True}


def write_pages(docs: Path) -> None:
    """Everything below ``generated``, anew."""
    root, results = docs / "generated", beside(docs, RESULTS).parent
    shutil.rmtree(root, ignore_errors=True)
    for name in ("terms", "statistics", "tutorial", "api"):
        (root / name).mkdir(parents=True)
    for symbol in TERMS:
        _write(root / "terms" / f"{symbol}.md", term_page(symbol, root / "terms"))
    _write(root / "terms" / "index.md", term_index())
    for name in STATISTICS:
        _write(root / "statistics" / f"{name}.md", statistic_page(name, root / "statistics"))
    _write(root / "statistics" / "index.md", statistic_index())
    _write(root / "units.md", units_page())
    _write(root / "help.md", help_pages())
    for page, lines in api_pages():
        _write(root / "api" / f"{page}.md", lines)
    _write(root / "methods.md", methods_page(root))
    _write(root / "accuracies.md", accuracies())
    _write(root / "efficiencies.md", efficiencies(results / "methods.md", "Each method"))
    _write(root / "curve_efficiencies.md", efficiencies(results / "methods.md", "Curves of other statistics"))
    _write(root / "terms" / "devices.md", devices_page())
    _write(root / "data_sheets.md", data_sheets_page())
    _write(root / "quantities.md", quantities_table())
    _write(root / "compared.md", compared_page(results / "recordings.md"))
    _write(root / "recordings.md", recordings_page(results / "recordings.md"))
    _write(root / "exports.md", exports_page())
    benchmark_pages(results, root / "benchmarks")
    slopes_figure(root)
    _write(root / "gallery.md", gallery_page(docs, root / "gallery"))
    run_tutorial(docs, root / "tutorial")


def _write(path: Path, lines: Iterable[str]) -> None:
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")

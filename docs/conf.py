"""Settings of the documentation site; `generate.py` writes the pages of the tables."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from allanite import __version__

project = "allanite"
author = "The allanite authors"
copyright = "The allanite authors, MIT license"  # noqa: A001 - Sphinx wants this name
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "generate", "mathml", "navigation", "tables"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
INCLUDED = ("help", "methods", "efficiencies", "accuracies", "exports", "recordings", "quantities", "compared")
exclude_patterns = [
    *(f"generated/{name}.md" for name in INCLUDED),
    "papers/*/table_*.md",
    "generate/*.md",
]  # included by others
default_role = "py:obj"  # names in docstrings lead to their own
suppress_warnings = ["ref.python"]  # an attribute such as `count` is one of several classes: the first will do

autodoc_typehints = "none"  # types stand in the docstrings, in the words of the field
autodoc_member_order = "bysource"
napoleon_use_ivar = True
napoleon_use_rtype = False
napoleon_preprocess_types = False

html_theme = "furo"
html_title = "allanite"
html_math_renderer = "mathml"
html_static_path = ["static"]
templates_path = ["templates"]
MOVED = {
    "accuracy": "known.html", "compensation_method": "compensation.html#why-not-ordinary-least-squares",
    "changelog": "https://github.com/allanite/allanite/blob/main/CHANGELOG.md",
    "data_sheets": "generated/data_sheets.html", "devices": "generated/terms/devices.html",
    "gyro_vertical": "vertical.html#the-best-time-constant",
    "json": "command.html#json-and-csv-output", "languages": "command.html#other-languages",
    "plugins": "architecture.html#plug-ins", "rate_and_angle": "rate_paper.html",
    "reference_data": "published_formulas.html#reference-data", "ros": "kalibr.html",
    "measured": "known.html", "speed": "known.html#running", "vertical_recording": "vertical.html#an-adis16405-at-rest",
    "will_not": "https://github.com/allanite/allanite/blob/main/VISION.md",
}  # fmt: skip
"""Former addresses of pages, and the present ones."""
MOVED |= {page.stem: f"translations/{page.stem}.html" for page in Path(__file__).parent.glob("translations/*.md")}
html_additional_pages = dict.fromkeys(MOVED, "moved.html")
html_context = {"moved": MOVED}
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#2E5C94", "color-brand-content": "#2E5C94"},
    "dark_css_variables": {"color-brand-primary": "#8FB4E3", "color-brand-content": "#8FB4E3"},
}

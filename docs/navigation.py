"""The navigation beside each page: titles of pages, without the sections and names that are on them."""

from collections.abc import Callable
from typing import Any

from docutils.nodes import document
from sphinx.addnodes import toctree
from sphinx.application import Sphinx


def setup(app: Sphinx) -> dict[str, bool]:
    """Before the theme asks for it."""
    app.connect("html-page-context", _with_titles_only, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _with_titles_only(app: Sphinx, _name: str, _template: str, context: dict[str, Any], _tree: document | None) -> None:
    """Sphinx copies all entries for every page, and then removes what is no title: here it is removed once."""
    whole: Callable[..., str] | None = context.get("toctree")

    def of_titles(**options: Any) -> str:
        entries, app.env.tocs = app.env.tocs, _titles(app)
        try:
            return whole(**options)
        finally:
            app.env.tocs = entries

    if whole is not None:
        context["toctree"] = of_titles


def _titles(app: Sphinx) -> dict[str, Any]:
    if not hasattr(app, "titles_of_pages"):
        app.titles_of_pages = {name: entries.deepcopy() for name, entries in app.env.tocs.items()}
        for entries in app.titles_of_pages.values():
            for page in entries:
                if len(page) > 1:  # the title, and a list of what is below it
                    page[1][:] = list(page[1].findall(toctree))
                    page[:] = page[: 1 + bool(len(page[1]))]
    return app.titles_of_pages

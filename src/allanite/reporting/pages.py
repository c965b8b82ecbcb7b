"""Which page a value becomes."""

from allanite.comparison.comparison import Comparison
from allanite.comparison.pooled import Pool
from allanite.reporting.comparison import html as compared
from allanite.study.analysis import Study

from . import html


def page(value: Study | Comparison | Pool) -> str:
    """The page of a value as text; see `allanite.report`."""
    return compared.page(value) if isinstance(value, (Comparison, Pool)) else html.page(value)

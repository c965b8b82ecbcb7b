"""Which page a value becomes."""

from allanite.comparison import Comparison
from allanite.pooled import Pool
from allanite.study import Study

from . import html
from .comparison import html as compared


def page(value: Study | Comparison | Pool) -> str:
    """The page of a value as text; see `allanite.report`."""
    return compared.page(value) if isinstance(value, (Comparison, Pool)) else html.page(value)

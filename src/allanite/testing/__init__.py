"""What every statistic, noise term, format, target and verb keeps: checks for tests of the packages that add some.

Each raises an AssertionError that says what is wrong. Those of this package's own rows are the same.

Examples
--------
>>> from allanite.statistics import STATISTICS
>>> check_statistic(STATISTICS["oadev"])
"""

from .readers import check_reader
from .statistics import check_statistic
from .targets import check_target
from .terms import check_term
from .verbs import check_verb

__all__ = ["check_reader", "check_statistic", "check_target", "check_term", "check_verb"]

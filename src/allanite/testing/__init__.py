"""What each format, statistic, noise term, target, data sheet and verb keeps: checks for packages that add any.

Each raises an AssertionError that says what is wrong. The tests of this package check its own rows by them, too.

Examples
--------
>>> from dataclasses import replace
>>> from allanite import STATISTICS
>>> check_statistic(STATISTICS["oadev"])
>>> check_statistic(replace(STATISTICS["oadev"], order=3))
Traceback (most recent call last):
    ...
AssertionError: statistic 'oadev': order is 3, but t^2 is not left out (check 'order')

What is known, and has a reason, is passed over, until it passes:

>>> mine = replace(STATISTICS["oadev"], order=3)
>>> check_statistic(mine, expected_failed_checks={"order": "a walk is wanted in it"})
"""

from .checks import CHECKS
from .rows import check_data_sheet, check_reader, check_statistic, check_target, check_verb
from .terms import check_term

__all__ = ["CHECKS", "check_data_sheet", "check_reader", "check_statistic", "check_target", "check_term", "check_verb"]

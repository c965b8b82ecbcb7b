"""Shares of so many records in committed tables, and what chance does to them."""

import math
import re


def records(page):
    """Number of records of each cell of a committed table."""
    return int(re.search(r"--records (\d+)", page.head)[1])


def first(cell):
    """The share of a cell that says more."""
    return float(cell.split()[0])


def chance(share, count):
    """2.6 standard errors of a share, %: one of 100 of so many records lies beyond, on either side one of 200."""
    return 260 * math.sqrt(share / 100 * (1 - share / 100) / count)


def binomial_tail(k, n, p):
    """Smaller of P(X <= k) and P(X >= k)."""
    terms = [math.comb(n, i) * p**i * (1 - p) ** (n - i) for i in range(n + 1)]
    return min(sum(terms[: k + 1]), sum(terms[k:]))

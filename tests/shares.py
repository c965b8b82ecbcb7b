"""Shares of so many records, and what chance does to them."""

import math


def binomial_tail(k, n, p):
    """Smaller of P(X <= k) and P(X >= k)."""
    terms = [math.comb(n, i) * p**i * (1 - p) ** (n - i) for i in range(n + 1)]
    return min(sum(terms[: k + 1]), sum(terms[k:]))

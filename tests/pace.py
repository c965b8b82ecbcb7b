"""Limits of time on machines of different speed, which others use as well."""

import time

IDLE = 0.016
"""Seconds of the loop below on the machine where the limits of the tests were set, without other work."""


def pace():
    """How many times slower this machine is at the moment, at least 1: the middle one of five short loops."""
    took = []
    for _ in range(5):
        start = time.perf_counter()
        sum(k * k for k in range(300_000))
        took.append(time.perf_counter() - start)
    return max(1.0, sorted(took)[2] / IDLE)

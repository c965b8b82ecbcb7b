"""A package that adds a format, a statistic, a noise term, a target and a verb with a result to allanite."""

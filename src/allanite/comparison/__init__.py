"""Before and after, unit against unit, run against run."""

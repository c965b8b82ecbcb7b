"""What a recording of some length can tell: bound, plan, check of the identification, typical sensors."""

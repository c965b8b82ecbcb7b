"""What can be learnt from a record of some length: bound, plan, check of the identification, typical sensors."""

"""Whether the model explains the record, and what it leaves."""

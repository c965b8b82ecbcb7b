"""Bodies of verbs that need more than one command: parse, compute, render."""

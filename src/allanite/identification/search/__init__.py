"""One search with one score: which components a record is made of, and the law of each coefficient."""

"""A compensation for people: table, figure, page; and for machines: CSV."""

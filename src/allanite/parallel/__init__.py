"""Parallel work: threads whose results are futures, processes that share work, and modules imported meanwhile."""

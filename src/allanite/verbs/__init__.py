"""Verbs of the command line that bring options of their own."""

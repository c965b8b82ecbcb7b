"""Targets, by what they are for."""

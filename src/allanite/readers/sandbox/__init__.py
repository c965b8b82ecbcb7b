"""Limits for hostile files."""

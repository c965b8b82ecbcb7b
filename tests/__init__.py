"""Everything that must hold: anchors, conformance, recordings, stories, and the parts one by one."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
"""Folder of the project."""

"""One format one file."""

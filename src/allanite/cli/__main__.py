"""``python -m allanite.cli`` is the program `allanite`."""

from allanite.cli import main

main()

"""``python -m allanite.cli`` is the program `allanite`."""

from . import main

main()

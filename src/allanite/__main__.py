"""``python -m allanite`` runs the program `allanite`."""

from allanite.cli import main

main()

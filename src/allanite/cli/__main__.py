"""``python -m allanite.cli`` runs the program `allanite`."""

from allanite.cli import main

main()

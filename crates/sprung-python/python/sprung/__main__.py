"""``python -m sprung`` runs the command line."""

from sprung._command import main

main()

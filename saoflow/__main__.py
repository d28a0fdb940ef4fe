"""``python -m saoflow``: the command line."""

from saoflow.cli import main

main()

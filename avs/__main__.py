"""``python -m avs``: one command per step of the workflow."""

from avs.cli import main

main()

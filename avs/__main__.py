"""``python -m avs``: one command per step of the workflow."""

from avs.commands.main import main

main()

"""``python -m avs``: one command per step of the workflow."""

from avs.system.job_process import guard

with guard():
    from avs.commands.main import main

    main()

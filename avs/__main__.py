"""``python -m avs``: one command per step of the workflow."""

from avs.system.job_client import run_by_server

run_by_server()  # returns where this process is to do the work

from avs.system.job_process import guard  # noqa: E402 -- takes a second, and who only waits for a job needs none of it

with guard():
    from avs.commands.main import main

    main()

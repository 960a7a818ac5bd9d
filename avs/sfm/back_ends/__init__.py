"""The back ends, one file each; a file with a ``BACK_END`` is found by its name and listed nowhere."""

"""The selection methods, one file a family: every module here with a ``METHODS`` dictionary is found by name."""

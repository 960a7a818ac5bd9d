"""Selection methods, found by name: every module of this folder with a ``METHODS`` dictionary, and installed plug-ins."""

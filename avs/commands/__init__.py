"""The command line, one file a stage; argument handling only."""

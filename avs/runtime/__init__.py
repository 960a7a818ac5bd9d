"""How long a selection takes: measured by itself, on one reconstruction that all methods share."""

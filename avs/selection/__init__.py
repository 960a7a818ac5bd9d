"""The contract of a selection method, the registry of all of them, and what several methods share."""

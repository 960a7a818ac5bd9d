"""An exploration from its first turn to its record."""

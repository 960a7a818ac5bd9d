"""The page: a folder of plain files that shows all that a run has recorded, opened from disk without a server."""

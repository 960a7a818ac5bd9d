"""Lenses, paths, exposure, and what a camera sees: pixels, depth, sparse points."""

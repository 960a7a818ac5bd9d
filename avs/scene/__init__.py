"""A capture: cameras, photographs, points and split, and how they lie on disk."""

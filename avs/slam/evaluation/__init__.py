"""What of a building was covered, and how well the map renders it."""

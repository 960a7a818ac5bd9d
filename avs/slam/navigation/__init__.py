"""Where a robot can stand in a building, how it moves there, and paths on grids."""

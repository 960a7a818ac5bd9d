"""Where things stand: gardens, rooms and flats, drawn from a seed."""

"""How a path is chosen: nearest frontier, chance, FisherRF as released, any method of Task A, and an oracle."""

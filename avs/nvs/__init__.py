"""View synthesis while views are selected (the paper's Task A): the loop, its record, evaluation and timing."""

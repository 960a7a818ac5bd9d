"""Active view selection: every method on the same scenes, reconstruction, budget and metrics."""

"""What every job needs around its work: files, errors, logs, provenance, weights, obstacles of the environment."""

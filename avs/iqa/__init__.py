"""Image quality: the paper's cross-reference network, and no-reference metrics."""

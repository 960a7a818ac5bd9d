"""Pretrained weights: one manifest, one cache folder, and an explicit command that downloads.

Nothing here imports torch, and nothing but ``avs.weights.download`` uses the network.
"""

from avs.weights.cache import locate, missing, verified

__all__ = ["locate", "missing", "verified"]

"""Pretrained weights: one manifest, one cache folder, and an explicit command that downloads.

Nothing here imports torch, and nothing but ``avs.system.weights.download`` uses the network.
"""

from avs.system.weights.cache import locate, missing, verified

__all__ = ["locate", "missing", "verified"]

"""The cross-reference image quality network: its data, its training, its checkpoints and its use."""

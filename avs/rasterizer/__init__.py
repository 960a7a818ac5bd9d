"""Rasterisation of 3D Gaussians on the CPU: kernels on tensors and arrays, which know nothing of the suite."""

"""3D Gaussian splatting (Kerbl et al. 2023, arXiv 2308.04079), on the CPU and on CUDA."""

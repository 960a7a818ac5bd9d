"""The mapper: SplaTAM's loop (Keetha et al., CVPR 2024, arXiv 2312.02126) on the suite's own rasteriser."""

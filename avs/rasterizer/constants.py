"""The numbers that define what is rendered: those of 3D Gaussian splatting as gsplat 1.5.3 has them.

3DGS is Kerbl et al., 2023 (arXiv 2308.04079) with its code ``diff-gaussian-rasterization``.
"""

ALPHA_MIN = 1.0 / 255.0
"""A pixel takes no notice of a Gaussian whose opacity there is below this (3DGS; gsplat: ALPHA_THRESHOLD)."""

ALPHA_MAX = 0.999
"""Opacity is held below 1, so that the transmittance stays above 0 (gsplat; 3DGS and FisherRF have 0.99)."""

TRANSMITTANCE_MIN = 1e-4
"""A pixel stops at the Gaussian that would bring its transmittance to this or below; that one is not blended (3DGS)."""

NEAR_PLANE, FAR_PLANE = 0.01, 1e10
"""Nearest and farthest depth of a centre (defaults of gsplat; 3DGS has 0.2 and no farthest). In scene units, of which a
scene's extent has five: see ``avs.scene.normalisation``."""

BLUR = 0.3
"""Variance in square pixels that is added to each image covariance (3DGS; gsplat: the default of ``eps2d``)."""

FIELD_OF_VIEW_MARGIN = 0.3
"""The projection's Jacobian is held beyond this share of the half field of view outside the image (3DGS: 1.3 tan)."""

LARGEST_RADIUS = 1e6
"""A Gaussian whose image reaches farther, in pixels, is left out: float32 cannot hold its conic."""

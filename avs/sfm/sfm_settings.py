"""Settings that back ends of structure from motion share; they are read without any of their libraries."""

from __future__ import annotations

from pydantic import Field

from avs.system.models import StrictModel


class FeatureSettings(StrictModel):
    """Of SIFT and of matching; the defaults are COLMAP's where nothing else is said."""

    features: int = Field(8192, ge=1, description="features of an image, at most")
    ratio: float = Field(0.8, gt=0, le=1, description="of the distances to the nearest and second nearest descriptor")
    error: float = Field(2.0, gt=0, description="pixels from the epipolar line, and of reprojection (COLMAP: 4)")
    fewest_inliers: int = Field(15, ge=5, description="matches of a pair of images whose poses are not known")
    partners: int = Field(20, ge=1, description="views near to it that a view of known pose is matched with")


class GuidedSettings(StrictModel):
    """Of the sparse points that tell dense stereo depths and common views, where poses are known."""

    features: int = Field(800, ge=8, description="SIFT features of an image, at most")
    partners: int = Field(10, ge=1, description="views near to it that a view is matched with")
    error: float = Field(1.5, gt=0, description="pixels from the epipolar line, and of reprojection")
    ratio: float = Field(0.8, gt=0, le=1, description="of the distances to the nearest two descriptors near the line")
    ratio_to_all: float = Field(0.9, gt=0, description="of the distances to that one and to the nearest of all others")
    likeness: float = Field(0.6, ge=-1, le=1, description="of two descriptors, at least; 1 is the same")
    least_angle: float = Field(2.0, gt=0, lt=90, description="degrees between the rays of a point, at least")


class StereoSettings(StrictModel):
    """Of depth maps."""

    sources: int = Field(8, ge=1, le=16, description="views that a view is compared with")
    active: int = Field(
        4, ge=2, le=16, description="of these, in which PatchMatch tries a new plane: those that suit the old one best"
    )
    planes: int = Field(64, ge=16, le=512, multiple_of=16, description="depths of the plane sweep, even in 1 / depth")
    sweep_side: int = Field(240, ge=32, description="long side in pixels of the pictures of the sweep, about")
    iterations: int = Field(2, ge=1, description="of PatchMatch, on the full pictures")
    agreements: int = Field(1, ge=0, description="times that depth maps are refined to agree with those of the sources")
    agreement_iterations: int = Field(1, ge=1, description="of PatchMatch, each of these times")


class FusionSettings(StrictModel):
    """Of COLMAP's fusion. A few views far apart agree less often than COLMAP's hundreds: hence the looser limits."""

    views: int = Field(2, ge=1, description="that must agree on a point (COLMAP: 5)")
    depth_error: float = Field(0.01, gt=0, description="relative difference of depths that agree (COLMAP: 0.01)")
    normal_error: float = Field(30.0, gt=0, le=180, description="degrees between normals that agree (COLMAP: 10)")
    pixel_error: float = Field(1.0, gt=0, description="pixels between projections that agree (COLMAP: 2)")
    worst_cost: float = Field(0.65, gt=0, le=2, description="matching cost above which a pixel has no depth")

"""Projection of a 3D Gaussian to the image plane and its derivative, for one Gaussian or for sixteen at once.

EWA splatting (Zwicker et al., 2001) as 3D Gaussian splatting uses it (Kerbl et al., 2023): with the covariance
``(R S)(R S)^T`` in the world, the rotation ``W`` of the camera and the Jacobian ``J`` of the perspective projection at
the centre, the covariance in the image is ``P P^T + eps2d I`` with ``P = J W R S``. Going through the 2x3 factor ``P``
instead of through covariances costs fewer operations and gives the determinant as a sum of squares, free of
cancellation.

Every function takes float32 numbers or :data:`~avs.rasterizer.simd.VECTOR`.
"""

from avs.rasterizer.kernels import Number, Numbers, inline
from avs.rasterizer.simd import maximum, minimum, square_root, where

# Guard of gsplat 1.5.3 against division by a vanishing compensation factor in the derivative.
_COMPENSATION_GUARD = 1e-6


@inline
def rotation_of(w: Number, x: Number, y: Number, z: Number) -> Numbers:
    """Return the rotation matrix, row by row, of a quaternion that need not have length one."""
    scale = 1.0 / square_root(w * w + x * x + y * y + z * z)
    w, x, y, z = w * scale, x * scale, y * scale, z * scale
    return (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )


@inline
def rotation_backward(w: Number, x: Number, y: Number, z: Number, v: Numbers) -> Numbers:
    """Return the gradient of the quaternion from that of its rotation matrix ``v``, given row by row."""
    scale = 1.0 / square_root(w * w + x * x + y * y + z * z)
    w, x, y, z = w * scale, x * scale, y * scale, z * scale
    v_w = 2.0 * (x * (v[7] - v[5]) + y * (v[2] - v[6]) + z * (v[3] - v[1]))
    v_x = 2.0 * (y * (v[1] + v[3]) + z * (v[2] + v[6]) + w * (v[7] - v[5]) - 2.0 * x * (v[4] + v[8]))
    v_y = 2.0 * (x * (v[1] + v[3]) + z * (v[5] + v[7]) + w * (v[2] - v[6]) - 2.0 * y * (v[0] + v[8]))
    v_z = 2.0 * (x * (v[2] + v[6]) + y * (v[5] + v[7]) + w * (v[3] - v[1]) - 2.0 * z * (v[0] + v[4]))
    radial = v_w * w + v_x * x + v_y * y + v_z * z
    return (
        (v_w - radial * w) * scale,
        (v_x - radial * x) * scale,
        (v_y - radial * y) * scale,
        (v_z - radial * z) * scale,
    )


@inline
def multiply(a: Numbers, b: Numbers) -> Numbers:
    """Return the product of two 3x3 matrices given row by row."""
    return (
        a[0] * b[0] + a[1] * b[3] + a[2] * b[6],
        a[0] * b[1] + a[1] * b[4] + a[2] * b[7],
        a[0] * b[2] + a[1] * b[5] + a[2] * b[8],
        a[3] * b[0] + a[4] * b[3] + a[5] * b[6],
        a[3] * b[1] + a[4] * b[4] + a[5] * b[7],
        a[3] * b[2] + a[4] * b[5] + a[5] * b[8],
        a[6] * b[0] + a[7] * b[3] + a[8] * b[6],
        a[6] * b[1] + a[7] * b[4] + a[8] * b[7],
        a[6] * b[2] + a[7] * b[5] + a[8] * b[8],
    )


@inline
def transpose(a: Numbers) -> Numbers:
    """Return the transpose of a 3x3 matrix given row by row."""
    return (a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8])


@inline
def to_camera(mean: Numbers, pose: Numbers) -> Numbers:
    """Return a centre in camera coordinates; ``pose`` is the rotation, row by row, then the translation."""
    return (
        pose[0] * mean[0] + pose[1] * mean[1] + pose[2] * mean[2] + pose[9],
        pose[3] * mean[0] + pose[4] * mean[1] + pose[5] * mean[2] + pose[10],
        pose[6] * mean[0] + pose[7] * mean[1] + pose[8] * mean[2] + pose[11],
    )


@inline
def _image_factor(centre: Numbers, axes: Numbers, scale: Numbers, lens: Numbers) -> Numbers:
    """Return the four entries of the Jacobian that are not 0, and ``P`` (2x3), row by row.

    ``lens`` is fx, fy, cx, cy and the bounds of x/z (low, high) and of y/z (low, high) beyond which the Jacobian is
    held.
    """
    inverse = 1.0 / centre[2]
    x = minimum(maximum(centre[0] * inverse, lens[4]), lens[5])
    y = minimum(maximum(centre[1] * inverse, lens[6]), lens[7])
    jacobian = (lens[0] * inverse, lens[1] * inverse, -lens[0] * x * inverse, -lens[1] * y * inverse)
    factor = (
        (jacobian[0] * axes[0] + jacobian[2] * axes[6]) * scale[0],
        (jacobian[0] * axes[1] + jacobian[2] * axes[7]) * scale[1],
        (jacobian[0] * axes[2] + jacobian[2] * axes[8]) * scale[2],
        (jacobian[1] * axes[3] + jacobian[3] * axes[6]) * scale[0],
        (jacobian[1] * axes[4] + jacobian[3] * axes[7]) * scale[1],
        (jacobian[1] * axes[5] + jacobian[3] * axes[8]) * scale[2],
    )
    return jacobian, factor


@inline
def project(mean: Numbers, quat: Numbers, scale: Numbers, pose: Numbers, lens: Numbers, eps2d: Number) -> Numbers:
    """Project a Gaussian.

    Returns:
        The centre in pixels (x, y), the depth along the optical axis, the conic (xx, xy, yy: the inverse of the blurred
        2D covariance), the blurred variances in x and y, and the opacity compensation of Mip-Splatting.
    """
    centre = to_camera(mean, pose)
    axes = multiply(pose, rotation_of(quat[0], quat[1], quat[2], quat[3]))
    _, p = _image_factor(centre, axes, scale, lens)
    xx = p[0] * p[0] + p[1] * p[1] + p[2] * p[2]
    xy = p[0] * p[3] + p[1] * p[4] + p[2] * p[5]
    yy = p[3] * p[3] + p[4] * p[4] + p[5] * p[5]
    minors = (p[0] * p[4] - p[1] * p[3], p[0] * p[5] - p[2] * p[3], p[1] * p[5] - p[2] * p[4])
    determinant = minors[0] * minors[0] + minors[1] * minors[1] + minors[2] * minors[2]
    blurred = determinant + eps2d * (xx + yy) + eps2d * eps2d
    inverse = 1.0 / blurred
    xx, yy = xx + eps2d, yy + eps2d
    depth = 1.0 / centre[2]
    image = (lens[0] * centre[0] * depth + lens[2], lens[1] * centre[1] * depth + lens[3])
    return image, centre[2], (yy * inverse, -xy * inverse, xx * inverse), (xx, yy), square_root(determinant * inverse)


@inline
def _covariance_backward(
    conic: Numbers, compensation: Number, eps2d: Number, v_conic: Numbers, v_compensation: Number
) -> Numbers:
    """Return the gradient (xx, xy, yy) with respect to the unblurred 2D covariance as a symmetric matrix."""
    a, b, c = conic
    half = 0.5 * v_conic[1]
    # -K V K for the conic K and its gradient V
    left = (a * v_conic[0] + b * half, a * half + b * v_conic[2], b * v_conic[0] + c * half, b * half + c * v_conic[2])
    factor = v_compensation * 0.5 / (compensation + _COMPENSATION_GUARD)
    rest = 1.0 - compensation * compensation
    trace = eps2d * (a * c - b * b)
    return (
        factor * (rest * a - trace) - (left[0] * a + left[1] * b),
        factor * rest * b - (left[0] * b + left[1] * c),
        factor * (rest * c - trace) - (left[2] * b + left[3] * c),
    )


# Long because its matrices are written out, a line for each element, which is a number or sixteen of them.
@inline
def project_backward(
    mean: Numbers,
    quat: Numbers,
    scale: Numbers,
    pose: Numbers,
    lens: Numbers,
    eps2d: Number,
    conic: Numbers,
    compensation: Number,
    v_image: Numbers,
    v_depth: Number,
    v_conic: Numbers,
    v_compensation: Number,
) -> Numbers:
    """Return the gradients of centre (3), quaternion (4), scale (3) and pose (9 + 3) from those of the projection."""
    centre = to_camera(mean, pose)
    rotation = rotation_of(quat[0], quat[1], quat[2], quat[3])
    axes = multiply(pose, rotation)
    jacobian, p = _image_factor(centre, axes, scale, lens)
    g = _covariance_backward(conic, compensation, eps2d, v_conic, v_compensation)

    # P P^T, then P = J M with M = axes S
    q = (
        2.0 * (g[0] * p[0] + g[1] * p[3]),
        2.0 * (g[0] * p[1] + g[1] * p[4]),
        2.0 * (g[0] * p[2] + g[1] * p[5]),
        2.0 * (g[1] * p[0] + g[2] * p[3]),
        2.0 * (g[1] * p[1] + g[2] * p[4]),
        2.0 * (g[1] * p[2] + g[2] * p[5]),
    )
    v_stretched = (
        jacobian[0] * q[0],
        jacobian[0] * q[1],
        jacobian[0] * q[2],
        jacobian[1] * q[3],
        jacobian[1] * q[4],
        jacobian[1] * q[5],
        jacobian[2] * q[0] + jacobian[3] * q[3],
        jacobian[2] * q[1] + jacobian[3] * q[4],
        jacobian[2] * q[2] + jacobian[3] * q[5],
    )
    v_scale = (
        axes[0] * v_stretched[0] + axes[3] * v_stretched[3] + axes[6] * v_stretched[6],
        axes[1] * v_stretched[1] + axes[4] * v_stretched[4] + axes[7] * v_stretched[7],
        axes[2] * v_stretched[2] + axes[5] * v_stretched[5] + axes[8] * v_stretched[8],
    )
    v_axes = (
        v_stretched[0] * scale[0],
        v_stretched[1] * scale[1],
        v_stretched[2] * scale[2],
        v_stretched[3] * scale[0],
        v_stretched[4] * scale[1],
        v_stretched[5] * scale[2],
        v_stretched[6] * scale[0],
        v_stretched[7] * scale[1],
        v_stretched[8] * scale[2],
    )
    q = (q[0] * scale[0], q[1] * scale[1], q[2] * scale[2], q[3] * scale[0], q[4] * scale[1], q[5] * scale[2])
    v_jacobian = (
        q[0] * axes[0] + q[1] * axes[1] + q[2] * axes[2],
        q[3] * axes[3] + q[4] * axes[4] + q[5] * axes[5],
        q[0] * axes[6] + q[1] * axes[7] + q[2] * axes[8],
        q[3] * axes[6] + q[4] * axes[7] + q[5] * axes[8],
    )
    v_rotation = multiply(transpose(pose), v_axes)
    v_quat = rotation_backward(quat[0], quat[1], quat[2], quat[3], v_rotation)

    inverse = 1.0 / centre[2]
    # where the direction is held, the Jacobian depends on the depth alone
    ratio_x, ratio_y = centre[0] * inverse, centre[1] * inverse
    v_x = where((ratio_x >= lens[4]) & (ratio_x <= lens[5]), -lens[0] * inverse * v_jacobian[2], 0.0)
    v_y = where((ratio_y >= lens[6]) & (ratio_y <= lens[7]), -lens[1] * inverse * v_jacobian[3], 0.0)
    v_x = v_x + lens[0] * v_image[0]
    v_y = v_y + lens[1] * v_image[1]
    v_z = (
        -(jacobian[0] * v_jacobian[0] + jacobian[1] * v_jacobian[1])
        - (jacobian[2] * v_jacobian[2] + jacobian[3] * v_jacobian[3])
        - (v_x * ratio_x + v_y * ratio_y)
    )
    v_centre = (v_x * inverse, v_y * inverse, v_z * inverse + v_depth)
    v_mean = (
        pose[0] * v_centre[0] + pose[3] * v_centre[1] + pose[6] * v_centre[2],
        pose[1] * v_centre[0] + pose[4] * v_centre[1] + pose[7] * v_centre[2],
        pose[2] * v_centre[0] + pose[5] * v_centre[1] + pose[8] * v_centre[2],
    )
    turned = multiply(v_axes, transpose(rotation))
    v_pose = (
        turned[0] + v_centre[0] * mean[0],
        turned[1] + v_centre[0] * mean[1],
        turned[2] + v_centre[0] * mean[2],
        turned[3] + v_centre[1] * mean[0],
        turned[4] + v_centre[1] * mean[1],
        turned[5] + v_centre[1] * mean[2],
        turned[6] + v_centre[2] * mean[0],
        turned[7] + v_centre[2] * mean[1],
        turned[8] + v_centre[2] * mean[2],
        v_centre[0],
        v_centre[1],
        v_centre[2],
    )
    return v_mean, v_quat, v_scale, v_pose

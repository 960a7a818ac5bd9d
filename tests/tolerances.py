"""Every tolerance of a numeric comparison in the tests, with its reason."""

# metrics/image.py: everything is float64; the greatest SSIM error comes from the cancellation in a variance near 0,
# about 1e-16 / C2, over a few hundred operations.
SSIM_FLOAT64 = 1e-11
PSNR_FLOAT64 = 1e-10
# The division by 255 happens at different places: a few roundings.
UINT8_EQUALS_FLOAT = 1e-12
# One image is rounded to float32 (6e-8); relative to an SSIM or PSNR of order one, with room for flat windows.
FLOAT32_INPUT = 1e-4
# avs/rasterizer/losses.py: float32 against float64; the variance under SSIM is a difference of numbers
# near 1, so that a rounding of 6e-8 stands beside C2 = 9e-4. Relative to the largest gradient of the image.
LOSS_VALUE = 1e-6
LOSS_GRADIENT = 1e-4
# Every window is flat there, so that the same rounding, 6e-8 / 9e-4, comes into every pixel with one sign.
LOSS_VALUE_FLAT = 1e-3

# The same network with the same weights, built in two ways: float32 in another order of operations at most.
LPIPS_SAME_NETWORK = 1e-5
# metrics/statistics.py: a coverage of 0.95 counted in 3,000 draws has a standard error of 0.004; three of them.
COVERAGE_COUNT = 0.012
# Beyond normal differences Student's t is an approximation. Measured with 20,000 draws, for all sizes of the scales:
# variances that differ between scenes by a factor of 9, or a skewness of 1, cost up to 0.02 of the coverage.
COVERAGE_APPROXIMATE = 0.03

# avs/iqa/cross_reference/backbones.py: merging a batch norm into a convolution rounds each weight once (6e-8); up to 26
# blocks deep, relative to the largest feature.
FUSED_CONVOLUTIONS = 1e-4
# avs/iqa/cross_reference/network.py: float32 against float64, or float32 summed in another order, through two decoder
# layers whose tokens are of order one; the network's output lies in 0..1.
FLOAT32_NETWORK = 1e-4
# avs/iqa/cross_reference/training_processes.py: gradients summed over processes in another order (6e-8), through twelve
# steps of AdamW, whose first steps divide a gradient by itself; relative to errors that the card has with six decimals.
SHARED_TRAINING = 1e-4
# avs/iqa/cross_reference/trained_scorer.py: weights and tokens rounded to 8 bits (4e-3), averaged over a map.
BFLOAT16_SCORE = 2e-3
# avs/iqa/cross_reference/backbones.py: float32 in another order through twelve transformer blocks; the tokens leave a
# norm, so that they are of order one.
FLOAT32_TRANSFORMER = 1e-4
# avs/rasterizer/adam.py: 20 steps of 0.01 on numbers of order one, each rounded to float32.
ADAM_STEPS = 2e-6

# avs/scene/cameras.py, avs/scene/scene.py: a few float64 operations, a rotation through a quaternion and back, on
# numbers of order one to ten.
FLOAT64_GEOMETRY = 1e-13
# avs/scene/scene.py: a projection in float64, pixel coordinates up to some thousands.
FLOAT64_PIXELS = 1e-9
# avs/scene/scene.py, representations/gaussians/ply.py: one rounding to float32, relative to the largest number.
FLOAT32_STORAGE = 1e-6
# avs/selectors/no_reference.py: known scores have two decimals, the last of them rounded more than once.
QUALITY_KNOWN = 0.01
# avs/iqa/no_reference/niqe.py: pyiqa rounds its window to float32, 3e-8 of squared luminances up to 65025, beside
# variances of order one in blurred images; relative, measured 7e-4.
NIQE_PYIQA = 2e-3
# The same window in float64, by rows and columns or at once: roundings of 1e-16 of squared luminances, whose difference
# is a variance; the root of one near zero keeps half of the digits.
LOCAL_MEAN = 1e-10
LOCAL_DEVIATION = 1e-4
# avs/datasets/transforms_file.py and others: poses in decimal text, inverted, through a quaternion and to the scene's
# unit and back, float64 of order one; a quaternion of text with nine decimals is right to 1e-9.
POSES_OF_TEXT = 1e-8
# avs/datasets/found_points.py: nine of ten points lie this near their surface, in units of which the cameras are three
# away: a pixel is 0.014 there, and rays meet under 6 degrees and more. Measured: 0.010; with
# points that two views see alone, 0.0135.
TRIANGULATED = 0.03
# avs/datasets/video_frames.py: mean difference in grey values of a frame after H.264 of high quality, and the way
# to YCbCr and back. Measured: 1.5 at most.
FRAME_OF_VIDEO = 3.0
# avs/datasets/photograph_poses.py: poses found by structure from motion of 12 photographs of 240 px, whose features are
# right to .3 px of 210 px focal length: .1 degrees each, less by hundreds of them; centres in shares of the radius of
# all cameras (1.5), three units from what they see. The lens is found too. Measured: within .2 and .01.
FOUND_ROTATIONS = 0.3
FOUND_CENTERS = 0.015
# avs/datasets/captures.py: the centroid of a dot of 2 px radius in 8 bits, after bilinear undistortion and resizing,
# whose neighbours' tails reach its window: 0.07 px at most; the distortions of the tests shift points by over ten
# times as much.
DOT_CENTROID = 0.1
# avs/datasets/captures.py: median reprojection error of structure from motion on real photographs of 480 px, as COLMAP
# leaves it (0.10 to 0.35 px).
REAL_REPROJECTION = 0.5
# avs/representations/gaussians/probes.py: in standard deviations. The mean of 400 squares has tails a little heavier
# than a normal distribution; some five hundred of them are compared.
PROBES_DEVIATIONS = 6.0

# avs/rasterizer/rasterization.py: float32 against float64. Colours and opacities are of order one; a few
# dozen Gaussians with a rounding of 1e-7 each, through exponents of up to 8. Relative to the largest depth.
RASTER_IMAGE = 1e-4
# Relative L2 norm; measured 2e-6, 2e-5 where one pixel of a threshold decides otherwise.
RASTER_GRADIENT = 1e-3
# The same where pixels stop, at transmittances of 1e-4 that divide the rounding of what is left; measured 3e-5.
RASTER_GRADIENT_SATURATED = 1e-3
# avs/rasterizer/fisher_diagonal.py: each element, relative; products of two gradients. Measured 1e-5, and 4e-4
# for Gaussians a hundred times as long as wide.
FISHER_DIAGONAL = 1e-3

# avs/datasets/embedded/geometry/ray_search.py: float32 positions of order one (6e-8), divided by a volume that is small
# for small triangles and slanting rays; the distance of a border in shares of the triangle's side, that of a ray in its
# own length.
RAY_BORDER = 1e-4
RAY_DISTANCE = 1e-4

# avs/datasets/embedded: the mesh is stored in float32 and cast again by the same rays.
EMBEDDED_DEPTH = 1e-6
# Mean colour difference of one place in two views of 64 pixels, relative to that of random places: shading depends on
# the view, and a pixel of one view is only a part of one of the other.
EMBEDDED_REPROJECTION = 0.75
# Share of observations whose point, moved by its error, slipped behind an edge: 0.3 of a pixel where a pixel is 2 cm.
EMBEDDED_HIDDEN = 0.06

# metrics/ranking.py: float64, sums of some hundred products of ranks.
RANKING = 1e-12
# avs/rasterizer/variance_rasterization.py: a sum of positive terms over the pixels, each a quotient of float32 weights
# that carry the exponents' rounding; a pixel whose end a rounding decides otherwise counts one Gaussian more or less.
VARIANCE_REDUCTION = 1e-4
# avs/rasterizer/likelihood.py: float64 inside, one rounding to float32.
LIKELIHOOD = 1e-6

# avs/selectors/fisherrf.py, popgs.py: sums in float64 in another order, of ratios of one sign.
INFORMATION_SUMS = 1e-12
# avs/scene/warping.py: float32 coordinates of a few hundred pixels, times differences of neighbouring colours up to 1;
# relative to a sum over pixels.
WARPING = 1e-4
# avs/rasterizer/front_weights.py: weights in float32, as in the rasteriser.
BLENDING_WEIGHTS = 1e-4
# avs/selectors/gauss_mi.py: evidence, weights and a rendered image in float32; relative.
GAUSS_MI = 1e-4

# avs/selectors: the same image at two places of one batch, where float32 sums run in another order. Measured 3e-11 in
# the mean of a network's map, and 3e-5 in BRISQUE, whose features of a smooth image divide by small variances.
SAME_IMAGE_IN_A_BATCH = 1e-4

# metrics/coverage.py: float64 throughout; differences of coordinates of order one.
COVERAGE_DISTANCE = 1e-12
# Extents in other units and places: quantiles of float64 coordinates up to 30 times the extent from the origin.
COVERAGE_UNITS = 1e-9
# Two stray points among 5,000 move a quantile by a fiftieth of a hundredth of the points.
COVERAGE_STRAY = 0.02
# 3,000 points on a sphere: the point straight above another is there, because both shells have the same directions.
COVERAGE_SHELLS = 1e-12
# avs/coverage/true_surface.py: depth is stored in float32.
COVERAGE_SURFACE = 1e-6
# avs/coverage: shares of a sphere's voxels, of which the reference and the truth hold other points where a voxel has
# several. Measured 0.01.
COVERAGE_OF_SPHERE = 0.03
# avs/sfm/stereo_vectors.py: a coordinate of float32 below 64 has an error of 4e-6; times steps of 255 grey values.
BILINEAR_SAMPLE = 1e-3
# avs/sfm/stereo_vectors.py: what two of Newton's steps leave of the guess's error of 3.4 %.
INVERSE_ROOT = 5e-6
# avs/sfm/plane_sweep.py, semi_global.py: running sums of float32 of grey values squared, up to 49 times 65025, whose
# difference is a variance of some thousands.
SWEEP_COST = 2e-3
# avs/sfm/dense_stereo.py, of 16 far-apart views of 160 px. Measured: a median relative error of 0.0091; 0.39 of the
# pixels of at most the greatest cost, which are 0.72 of all, within 1 % of the extent; 0.55 of the fused points.
DENSE_DEPTH = 0.011
DENSE_WITHIN = 0.35
DENSE_COVERED = 0.6
DENSE_WITHIN_CLOUD = 0.51

# The same on CUDA and on the CPU, tests/*/test_*cuda.py: float32 in another order and with the GPU's fast exponentials
# (gsplat is compiled with -use_fast_math); one pixel at the threshold of blending decides otherwise, by 1/255 at most.
CUDA_IMAGE = 5e-3
CUDA_GRADIENT = 1e-2
CUDA_LOSS_VALUE = 1e-5
# Relative L2 norm: under a variance near 0 a rounding of 6e-8 stands beside C2 = 9e-4; measured 2e-4.
CUDA_LOSS_GRADIENT = 1e-3
CUDA_REDUCTION = 1e-3
CUDA_CAPABILITY = 1e-2
# Decibels: another order of sums makes another trajectory.
CUDA_FIT = 1.5
CUDA_EPISODE = 1.0

# metrics/significance.py: of 200 draws, 5 % have a standard deviation of 1.5 %; twice that.
FALSE_FINDINGS = 0.03
# The table of the literature has three decimals of the quantile, times about one.
NEMENYI_TABLE = 2e-3
# A p value from 10,000 permutations has a standard deviation of half a percent at most; the chi-squared limit is one.
PERMUTATIONS = 0.015
# Shares of 4,000 draws near 80 % have a standard deviation of 0.6 %; three times that.
POWER = 0.02

# avs/report/formats/latex.py: points by which a line may stand out of its column, where a long word cannot be parted.
LATEX_OVERFULL = 30.0

# avs/slam/mapping/tracking.py: central differences over 2e-3 in a float32 loss of a few thousand pixels; Gaussians that
# enter or leave a pixel at opacity 1/255 are steps of the loss. Relative to the largest gradient.
SLAM_POSE_GRADIENT = 0.05
# avs/slam/evaluation/seen_surface.py: a share of about a fifth counted in 40,000 draws has a standard error of 0.002;
# four of them.
SLAM_AREA_SHARE = 0.008
# avs/slam/scoring/fisher_path_scorer.py: float32 squares of one kernel against a backward pass for every pixel,
# relative to each value and to the largest.
SLAM_FISHER = 2e-3

# avs/representations: float32 kernels of lookups against torch in float64, relative to the largest value. Places are a
# dozen products of numbers up to 2; weights are products of two dozen exponentials; gradients sum some hundred samples.
FIELD_PLACES = 2e-5
FIELD_VALUES = 2e-5
FIELD_GRADIENTS = 1e-4
# Decibels after 40 steps: another order of sums makes another trajectory.
FIELD_FIT = 0.5

"""The rasteriser against its slow twin: images, gradients, edges, options."""

import pytest
import torch
from tolerances import RASTER_GRADIENT, RASTER_GRADIENT_SATURATED, RASTER_IMAGE

from avs.rasterizer.rasterization import rasterization
from tests.rasterizer import reference_renderer as reference

WIDTH, HEIGHT, CAMERAS = 45, 37, 2
NAMES = ("means", "quats", "scales", "opacities", "colors", "viewmats", "backgrounds")


def gaussians(count, seed, sh_degree=None, opaque=False, size=1.0):
    """Random Gaussians, float64; some lie behind the cameras and some far outside their fields of view."""
    generator = torch.Generator().manual_seed(seed)

    def uniform(*shape):
        return torch.rand(*shape, generator=generator, dtype=torch.float64)

    means = (uniform(count, 3) - 0.5) * torch.tensor([4.0, 4.0, 3.5]) + torch.tensor([0.0, 0.0, 1.5])
    quats = torch.randn(count, 4, generator=generator, dtype=torch.float64)
    scales = torch.exp(2 * uniform(count, 3) - 4) * size
    opacities = uniform(count) * 0.1 + 0.95 if opaque else uniform(count) * 0.9 + 0.05
    opacities = opacities.clamp(max=1.0)
    colors = uniform(count, 3)
    if sh_degree is not None:
        colors = 0.4 * torch.randn(count, (sh_degree + 1) ** 2, 3, generator=generator, dtype=torch.float64)
    return [means, quats, scales, opacities, colors]


def cameras(count, seed, width=WIDTH, height=HEIGHT):
    """Cameras a little apart, with an off-centre principal point and unequal focal lengths."""
    generator = torch.Generator().manual_seed(seed)
    turn = torch.cat([torch.ones(count, 1), 0.08 * torch.randn(count, 3, generator=generator)], 1).double()
    viewmats = torch.eye(4, dtype=torch.float64).repeat(count, 1, 1)
    viewmats[:, :3, :3] = reference.rotation_matrices(turn)
    viewmats[:, :3, 3] = 0.1 * torch.randn(count, 3, generator=generator).double()
    intrinsics = torch.tensor([[0.9 * width, 0, 0.45 * width], [0, 0.95 * width, 0.55 * height], [0, 0, 1]])
    return viewmats, intrinsics.double().repeat(count, 1, 1)


def leaves(tensors, dtype):
    return [x.to(dtype).clone().requires_grad_() for x in tensors]


def compare(scene, backgrounds=None, gradient_tolerance=RASTER_GRADIENT, **options):
    """Check images and all gradients, with random weights of every output as the loss."""
    viewmats, intrinsics = cameras(CAMERAS, 1)
    tensors = [*scene, viewmats] + ([] if backgrounds is None else [backgrounds])
    slow, fast = leaves(tensors, torch.float64), leaves(tensors, torch.float32)
    pairs = [
        reference.render(
            *slow[:5],
            slow[5][c],
            intrinsics[c],
            WIDTH,
            HEIGHT,
            background=slow[6][c] if len(slow) > 6 else None,
            **options,
        )
        for c in range(CAMERAS)
    ]
    images, alphas = (torch.stack(x) for x in zip(*pairs, strict=True))
    result = rasterization(
        *fast[:6], intrinsics.float(), WIDTH, HEIGHT, backgrounds=fast[6] if len(fast) > 6 else None, **options
    )
    assert (images - result[0]).abs().max() < RASTER_IMAGE * max(1.0, float(images.detach().abs().max()))
    assert (alphas - result[1]).abs().max() < RASTER_IMAGE
    weights, weights_alpha = torch.randn(images.shape), torch.randn(alphas.shape)
    ((images * weights).sum() + (alphas * weights_alpha).sum()).backward()
    ((result[0] * weights).sum() + (result[1] * weights_alpha).sum()).backward()
    for name, x, y in zip(NAMES, slow, fast, strict=False):
        if x.grad is not None:
            assert (x.grad - y.grad).norm() <= gradient_tolerance * x.grad.norm(), name
    return images, alphas


@pytest.fixture(autouse=True)
def _seed():
    torch.manual_seed(0)


def test_plain_colors():
    compare(gaussians(250, 0))


@pytest.mark.parametrize("degree", [0, 1, 2, 3, 4])
def test_harmonics(degree):
    compare(gaussians(150, degree, sh_degree=degree), sh_degree=degree)


@pytest.mark.parametrize("render_mode", ["D", "ED", "RGB+D", "RGB+ED"])
def test_depth(render_mode):
    compare(gaussians(150, 2), render_mode=render_mode)


def test_background_and_antialiasing():
    compare(gaussians(200, 3), backgrounds=torch.rand(CAMERAS, 3).double(), rasterize_mode="antialiased")


def test_saturated_pixels():
    scene = gaussians(300, 4, opaque=True, size=4.0)
    _, alphas = compare(
        scene, backgrounds=torch.rand(CAMERAS, 3).double(), gradient_tolerance=RASTER_GRADIENT_SATURATED
    )
    assert (alphas > 1 - 1e-3).double().mean() > 0.9  # nearly all pixels stop


def test_gradients_are_derivatives_of_the_image():
    """Central differences of the float64 twin at single elements, so that the twin's autograd is not taken on trust."""
    scene = gaussians(60, 5, sh_degree=1)
    viewmats, intrinsics = cameras(1, 1)
    weights = torch.randn(HEIGHT, WIDTH, 3, dtype=torch.float64)
    fast = leaves([*scene, viewmats], torch.float32)
    image, _, _ = rasterization(*fast, intrinsics.float(), WIDTH, HEIGHT, sh_degree=1)
    (image[0] * weights).sum().backward()
    for place, tensor in enumerate(fast[:5]):
        at = int(tensor.grad.abs().argmax())
        values = []
        for step in (1e-6, -1e-6):
            moved = [x.clone() for x in scene]
            moved[place].view(-1)[at] += step
            values.append(
                (reference.render(*moved, viewmats[0], intrinsics[0], WIDTH, HEIGHT, sh_degree=1)[0] * weights).sum()
            )
        difference = (values[0] - values[1]) / 2e-6
        assert float(tensor.grad.view(-1)[at]) == pytest.approx(float(difference), rel=RASTER_GRADIENT), NAMES[place]


def test_same_bits_each_time():
    viewmats, intrinsics = cameras(CAMERAS, 1)
    results = []
    for _ in range(2):
        fast = leaves([*gaussians(250, 6), viewmats], torch.float32)
        images, alphas, meta = rasterization(*fast, intrinsics.float(), WIDTH, HEIGHT, absgrad=True)
        (images.sin().sum() + alphas.sum()).backward()
        results.append([images, alphas, meta["means2d"].absgrad, *(x.grad for x in fast)])
    assert all(torch.equal(x, y) for x, y in zip(*results, strict=True))


def test_colors_per_camera():
    scene = [x.float() for x in gaussians(100, 7)]
    viewmats, intrinsics = (x.float() for x in cameras(CAMERAS, 1))
    shared, _, _ = rasterization(*scene, viewmats, intrinsics, WIDTH, HEIGHT)
    scene[4] = scene[4].repeat(CAMERAS, 1, 1)
    own, _, _ = rasterization(*scene, viewmats, intrinsics, WIDTH, HEIGHT)
    assert torch.equal(shared, own)


def test_gradients_that_densification_reads():
    """The gradient of a 2D centre is that of a shift of the image; its absolute sum over pixels is no smaller."""
    viewmats, intrinsics = (x.float() for x in cameras(CAMERAS, 1))
    fast = leaves(gaussians(100, 8), torch.float32)
    images, _, meta = rasterization(*fast, viewmats, intrinsics, WIDTH, HEIGHT, absgrad=True, packed=False)
    meta["means2d"].retain_grad()
    (images * torch.randn(images.shape)).sum().backward()
    gradient, absolute = meta["means2d"].grad, meta["means2d"].absgrad
    assert gradient.shape == (CAMERAS, 100, 2)
    assert (absolute >= gradient.abs() * (1 - 1e-4) - 1e-5).all()
    assert (gradient[meta["radii"].min(-1).values == 0] == 0).all()
    assert meta["radii"].dtype == torch.int32
    assert meta["n_cameras"] == CAMERAS


@pytest.mark.parametrize(("width", "height"), [(1, 1), (8, 8), (9, 17), (3, 40)])
def test_sizes_that_are_no_multiples_of_a_tile(width, height):
    scene = gaussians(80, 9, size=3.0)
    viewmats, intrinsics = cameras(1, 2, width, height)
    expected, _ = reference.render(*scene, viewmats[0], intrinsics[0], width, height)
    image, _, _ = rasterization(*[x.float() for x in (*scene, viewmats, intrinsics)], width, height)
    assert (image[0] - expected).abs().max() < RASTER_IMAGE


@pytest.mark.parametrize("count", [0, 5])
def test_nothing_to_see(count):
    scene = leaves([x[:count] for x in gaussians(5, 0)], torch.float32)
    viewmats, intrinsics = (x.float() for x in cameras(1, 1))
    viewmats[:, 2, 3] = -100.0
    image, alpha, meta = rasterization(*scene, viewmats, intrinsics, 20, 10, backgrounds=torch.full((1, 3), 0.25))
    image.sum().backward()
    assert (image == 0.25).all()
    assert (alpha == 0).all()
    assert (meta["radii"] == 0).all()
    assert all((x.grad == 0).all() for x in scene)


def test_numbers_that_are_not_finite_leave_their_gaussian_out():
    scene = [x.float() for x in gaussians(40, 1)]
    viewmats, intrinsics = (x.float() for x in cameras(1, 1))
    expected, _, _ = rasterization(*(x[4:] for x in scene), viewmats, intrinsics, WIDTH, HEIGHT)
    scene[0][0], scene[2][1], scene[1][2], scene[2][3] = torch.nan, torch.inf, 0.0, 1e20
    image, _, _ = rasterization(*scene, viewmats, intrinsics, WIDTH, HEIGHT)
    assert torch.equal(image, expected)


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"camera_model": "fisheye"}, NotImplementedError),
        ({"covars": torch.zeros(5, 3, 3)}, NotImplementedError),
        ({"with_ut": True}, NotImplementedError),
        ({"sparse_grad": True}, NotImplementedError),
        ({"distributed": True}, NotImplementedError),
        ({"render_mode": "N"}, ValueError),
        ({"rasterize_mode": "sharp"}, ValueError),
        ({"sh_degree": 7}, ValueError),
        ({"width": 0}, ValueError),
        ({"quats": torch.zeros(5, 3)}, ValueError),
        ({"means": torch.zeros(5, 3).double()}, ValueError),
        ({"backgrounds": torch.zeros(1, 4)}, ValueError),
    ],
)
def test_refusals_name_the_argument(options, error):
    names = ("means", "quats", "scales", "opacities", "colors")
    arguments = dict(zip(names, (x.float() for x in gaussians(5, 0)), strict=True))
    viewmats, intrinsics = (x.float() for x in cameras(1, 1))
    arguments |= {"viewmats": viewmats, "Ks": intrinsics, "width": 8, "height": 8} | options
    with pytest.raises(error, match=next(iter(options))):
        rasterization(**arguments)

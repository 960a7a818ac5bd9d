"""Fields on CUDA: they render what they render on the CPU, and learn as well."""

import pytest
import torch
from test_radiance_fields import CAMERAS, SMALL, built, psnr, scene, views  # noqa: F401
from tolerances import CUDA_FIT, CUDA_IMAGE

from avs.representations import kinds

pytestmark = pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU that torch can use")
every_field = pytest.mark.parametrize("kind", SMALL)


def on_cuda(scene, kind):  # noqa: F811
    return kinds.build(scene, [0, 1], kinds.create_settings({"kind": kind, **SMALL[kind]}), 1, "cuda")


@every_field
def test_renders_what_it_renders_on_the_cpu(scene, views, kind, tmp_path):  # noqa: F811
    here, there = built(scene, kind), on_cuda(scene, kind)
    here.fit(views, 60)
    here.save(tmp_path / "here.safetensors")
    there.load(tmp_path / "here.safetensors")
    difference = here.render(CAMERAS).rgb - there.render(CAMERAS).rgb
    assert abs(difference).mean() <= CUDA_IMAGE


@every_field
def test_learns_as_well_as_on_the_cpu(scene, views, kind):  # noqa: F811
    here, there = built(scene, kind), on_cuda(scene, kind)
    for representation in (here, there):
        representation.fit(views, 150)
    assert all(each.device.type == "cuda" for each in there.field.parameters.values())
    assert psnr(there, views) == pytest.approx(psnr(here, views), abs=CUDA_FIT)


@every_field
def test_a_resumed_run_stays_on_the_gpu(scene, views, kind, tmp_path):  # noqa: F811
    first, second = on_cuda(scene, kind), on_cuda(scene, kind)
    first.fit(views, 10)
    first.save(tmp_path / "field.safetensors")
    second.load(tmp_path / "field.safetensors")
    second.fit(views, 10)
    assert second.iteration == 20
    assert all(each.device.type == "cuda" for each in second.field.parameters.values())

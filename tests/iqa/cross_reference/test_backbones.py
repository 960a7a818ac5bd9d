import numpy as np
import pytest
import torch
from PIL import Image
from safetensors.torch import save_file

from avs.iqa.cross_reference.backbone_weights import find_weights
from avs.iqa.cross_reference.backbones import (
    REPVIT_TAPS,
    DINOv2,
    EfficientNetLite0,
    RepViT,
    fused,
    open_residual_branches,
)
from avs.iqa.cross_reference.efficientnet_names import timm_names
from avs.system.compatibility import prepare_torchvision
from avs.system.errors import UserError
from avs.system.weights import verified
from avs.system.weights.cache import VARIABLE
from avs.system.weights.reading import read_state
from tests.tolerances import FLOAT32_TRANSFORMER, FUSED_CONVOLUTIONS


@pytest.fixture(scope="module")
def timm_model():
    prepare_torchvision()
    import timm

    torch.manual_seed(0)
    return timm.create_model("repvit_m0_9", pretrained=False, num_classes=0).eval()


@pytest.fixture(scope="module")
def weights(timm_model, tmp_path_factory):
    path = tmp_path_factory.mktemp("weights") / "timm" / "repvit_m0_9.dist_450e_in1k.safetensors"
    path.parent.mkdir()
    state = {key: value.contiguous() for key, value in timm_model.state_dict().items()}
    save_file({**state, "head.head.l.weight": torch.zeros(1000, 384)}, path)
    return path


def test_blocks_have_the_numbering_of_the_publication():
    backbone = RepViT("A")
    strides, channels, x = [], [], torch.zeros(1, 3, 64, 64)
    x = backbone.stem(x)
    for block in backbone.blocks:
        x = block(x)
        strides.append(64 // x.shape[-1])
        channels.append(x.shape[1])
    # blocks 3, 7 and 23 are the ones that halve the resolution: 26 blocks in all
    assert strides == [4] * 3 + [8] * 4 + [16] * 16 + [32] * 3
    assert channels == [48] * 3 + [96] * 4 + [192] * 16 + [384] * 3


@pytest.mark.parametrize(
    ("taps", "modules"),
    [
        # timm keeps a stage's last block as the next stage's downsample.pre_block
        (
            "A",
            [
                "stages.1.downsample.pre_block",
                "stages.2.downsample.pre_block",
                "stages.3.downsample.pre_block",
                "stages.3",
            ],
        ),
        ("B", ["stages.0", "stages.1", "stages.2", "stages.3.blocks.0"]),
    ],
)
def test_taps_are_the_named_modules_of_timm(timm_model, weights, taps, modules):
    found = {}
    hooks = [
        timm_model.get_submodule(name).register_forward_hook(
            lambda _, __, output, name=name: found.update({name: output})
        )
        for name in modules
    ]
    images = torch.rand(2, 3, 70, 98, generator=torch.Generator().manual_seed(1))
    with torch.inference_mode():
        timm_model.forward_features(images)
        features = RepViT(taps, weights).eval()(images)
    for hook in hooks:
        hook.remove()
    assert len(features) == len(REPVIT_TAPS[taps]) == 4
    for own, name in zip(features, modules, strict=True):
        assert torch.equal(own, found[name])


def test_feature_sizes_at_518_pixels():
    with torch.inference_mode():
        features = RepViT("A").eval()(torch.zeros(1, 3, 518, 518))
    assert [tuple(f.shape[1:]) for f in features] == [(48, 130, 130), (96, 65, 65), (192, 33, 33), (384, 17, 17)]


def test_no_block_beyond_the_last_tap_is_kept():
    assert [len(RepViT(taps).blocks) for taps in "AB"] == [26, 25]


@pytest.mark.parametrize("taps", ["A", "B"])
def test_fused_backbone_computes_the_same(taps, network):
    backbone = RepViT(taps).eval()
    if taps == "A":
        backbone = network.backbone  # with statistics in its batch norms
    images = torch.rand(2, 3, 56, 70, generator=torch.Generator().manual_seed(2))
    merged = fused(backbone)
    assert not any(isinstance(module, torch.nn.BatchNorm2d) for module in merged.modules())
    with torch.inference_mode():
        for expected, actual in zip(backbone(images), merged(images), strict=True):
            torch.testing.assert_close(actual, expected, rtol=0, atol=FUSED_CONVOLUTIONS * float(expected.abs().max()))


def test_weights_are_found_without_the_network(weights, monkeypatch, tmp_path):
    monkeypatch.setattr("socket.socket.connect", lambda *_: pytest.fail("used the network"))
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    assert find_weights("repvit_m0_9", "no_such_tag") is None
    monkeypatch.setenv(VARIABLE, str(weights.parent.parent))
    assert find_weights("repvit_m0_9") == weights
    other = weights.with_name("repvit_m0_9.other.safetensors")
    other.write_bytes(b"")
    assert find_weights("repvit_m0_9", "other") == other


def test_weights_that_changed_since_their_download_are_refused(weights, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(weights.parent.parent))
    record = weights.with_name(f"{weights.name}.sha256")
    record.write_text(f"{'0' * 64}  {weights.name}\n")
    try:
        with pytest.raises(UserError, match="its SHA-256 starts with"):
            find_weights("repvit_m0_9")
    finally:
        record.unlink()


def test_dinov2_reads_timms_weights_and_keeps_its_layout(tmp_path):
    """timm's own model gives the same tokens at 518 pixels, where no position embedding is resized."""
    prepare_torchvision()
    import timm

    torch.manual_seed(0)
    model = timm.create_model("vit_small_patch14_dinov2", pretrained=False, num_classes=0).eval()
    path = tmp_path / "weights.safetensors"
    save_file({**model.state_dict(), "mask_token": torch.zeros(1, 384)}, path)
    backbone = DINOv2(path).eval()
    images = torch.rand(1, 3, 518, 518, generator=torch.Generator().manual_seed(1))
    with torch.inference_mode():
        expected = model.forward_features(images)[:, 1:]
        (actual,) = backbone(images)
    assert actual.shape == (1, 384, 37, 37)
    torch.testing.assert_close(actual.flatten(2).transpose(1, 2), expected, rtol=0, atol=FLOAT32_TRANSFORMER)


def test_tokens_of_a_random_dinov2_differ_from_one_another():
    """Its features must not fade away when it stays random: over the tokens they vary about as much as in size."""
    torch.manual_seed(0)
    backbone = DINOv2().eval()
    open_residual_branches(backbone)
    images = torch.randn(2, 3, 98, 98, generator=torch.Generator().manual_seed(1))
    with torch.inference_mode():
        (features,) = backbone(images)
    tokens = features.flatten(2).transpose(1, 2).flatten(0, 1)
    assert float(tokens.std(dim=0).mean()) > 0.3 * float(tokens.square().mean().sqrt())


@pytest.fixture(scope="module")
def lite0_weights():
    """The file of the package; it is one of the packages that are installed for the tests."""
    return verified("efficientnet-lite0")


@pytest.fixture(scope="module")
def lite0_model(lite0_weights):
    prepare_torchvision()
    import timm

    model = timm.create_model("tf_efficientnet_lite0", pretrained=False).eval()
    state = read_state(lite0_weights, "")
    model.load_state_dict(timm_names(state, [len(stage) for stage in model.blocks]))  # strictly
    return model


def test_lite0_has_timms_feature_maps_at_half_resolutions(lite0_model, lite0_weights):
    backbone = EfficientNetLite0(lite0_weights).eval()
    images = torch.rand(2, 3, 70, 98, generator=torch.Generator().manual_seed(1))
    with torch.inference_mode():
        features = backbone(images)
        last = lite0_model.blocks(lite0_model.bn1(lite0_model.conv_stem(images)))
    assert torch.equal(features[-1], last)
    assert [each.shape[1] for each in features] == list(backbone.channels) == [24, 40, 112, 320]
    assert [tuple(each.shape[2:]) for each in features] == [(18, 25), (9, 13), (5, 7), (3, 4)]


def test_lite0_sees_what_a_photograph_shows(lite0_model, shared_scenes):
    """Weights under wrong names, or images normalised otherwise, would load and see nothing."""
    path = sorted((shared_scenes / "fox" / "images").iterdir())[20]
    image = Image.open(path).convert("RGB").resize((224, 224), Image.Resampling.BICUBIC)
    pixels = torch.from_numpy(np.asarray(image, dtype=np.float32) / 255).permute(2, 0, 1)[None]
    mean, deviation = EfficientNetLite0.mean[0], EfficientNetLite0.deviation[0]
    with torch.inference_mode():
        logits = lite0_model((pixels - mean) / deviation)
    assert set(logits.topk(3).indices[0].tolist()) & {277, 278, 279, 280}  # ImageNet's four foxes


def test_fused_lite0_computes_the_same(lite0_weights):
    backbone = EfficientNetLite0(lite0_weights).eval()
    images = torch.rand(2, 3, 56, 70, generator=torch.Generator().manual_seed(2)) * 2 - 1
    merged = fused(backbone)
    assert not any(isinstance(module, torch.nn.BatchNorm2d) for module in merged.modules())
    with torch.inference_mode():
        for expected, actual in zip(backbone(images), merged(images), strict=True):
            torch.testing.assert_close(actual, expected, rtol=0, atol=FUSED_CONVOLUTIONS * float(expected.abs().max()))


def test_lite0_refuses_what_is_not_its_file(lite0_weights, tmp_path):
    truncated, foreign = tmp_path / "truncated.pth", tmp_path / "foreign.pth"
    truncated.write_bytes(lite0_weights.read_bytes()[:1000])
    torch.save({"stem": torch.zeros(1)}, foreign)
    for path in (truncated, foreign):
        with pytest.raises(UserError, match=path.name):
            EfficientNetLite0(path)


def test_damaged_or_foreign_weights_are_refused(weights, tmp_path):
    truncated = tmp_path / "truncated.safetensors"
    truncated.write_bytes(weights.read_bytes()[:1000])
    foreign = tmp_path / "foreign.safetensors"
    save_file({"stem": torch.zeros(1)}, foreign)
    for path in (truncated, foreign, tmp_path / "absent.safetensors"):
        with pytest.raises(UserError, match=path.name):
            RepViT("A", path)

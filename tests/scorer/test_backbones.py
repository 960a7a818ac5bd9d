import pytest
import torch
from safetensors.torch import save_file

from avs.compatibility import prepare_torchvision
from avs.errors import UserError
from avs.scorer.backbones import REPVIT_TAPS, WEIGHTS_VARIABLE, RepViT, find_weights, fused
from tests.tolerances import FUSED_CONVOLUTIONS


@pytest.fixture(scope="module")
def timm_model():
    prepare_torchvision()
    import timm

    torch.manual_seed(0)
    return timm.create_model("repvit_m0_9", pretrained=False, num_classes=0).eval()


@pytest.fixture(scope="module")
def weights(timm_model, tmp_path_factory):
    path = tmp_path_factory.mktemp("weights") / "repvit_m0_9.dist_450e_in1k.safetensors"
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
    monkeypatch.setenv("HF_HUB_CACHE", str(tmp_path))
    monkeypatch.delenv(WEIGHTS_VARIABLE, raising=False)
    monkeypatch.setattr("socket.socket.connect", lambda *_: pytest.fail("used the network"))
    assert find_weights("repvit_m0_9", "no_such_tag") is None
    monkeypatch.setenv(WEIGHTS_VARIABLE, str(weights.parent))
    assert find_weights("repvit_m0_9", "dist_450e_in1k") == weights


def test_damaged_or_foreign_weights_are_refused(weights, tmp_path):
    truncated = tmp_path / "truncated.safetensors"
    truncated.write_bytes(weights.read_bytes()[:1000])
    foreign = tmp_path / "foreign.safetensors"
    save_file({"stem": torch.zeros(1)}, foreign)
    for path in (truncated, foreign, tmp_path / "absent.safetensors"):
        with pytest.raises(UserError, match=path.name):
            RepViT("A", path)

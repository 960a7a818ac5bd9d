"""Time of a cross-reference network's pass over a candidate by what computes it, as a ratio to the suite's own way.

Run from the root of the repository: ``python -m tests.benchmarks.bench_inference``. The suite merges batch norms into
convolutions and lays images out by pixel (channels last). Beside it stand the network without either, in bfloat16,
compiled by torch (``torch.compile``), and in ONNX Runtime and OpenVINO, which the suite does not depend on: what is
not installed is left out. A candidate's pass is its backbone and the comparison with five encoded photographs.

Times are of the process's CPU on one thread, medians over interleaved rounds, in brackets the least and greatest ratio.
Beside a ratio stands the greatest difference of a predicted SSIM.
"""

from __future__ import annotations

import argparse
import importlib.util
import io
import os
import time
from collections.abc import Callable

for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np  # noqa: E402
import torch  # noqa: E402
from torch import Tensor, nn  # noqa: E402

from avs.config.run_config import ScorerSettings  # noqa: E402
from avs.iqa.cross_reference.backbones import fused  # noqa: E402
from avs.iqa.cross_reference.network import CrossReferenceNetwork, build_network  # noqa: E402
from avs.iqa.cross_reference.scorer_settings import BACKBONE_OF  # noqa: E402

REFERENCES = 5
Pass = Callable[[Tensor], Tensor]


class Whole(nn.Module):
    """A candidate's pass as one module: the maps of images compared with what is kept of photographs."""

    def __init__(self, network: CrossReferenceNetwork, memory: Tensor) -> None:
        """Take a network, and keys and values of the photographs ``[1, tokens, values]``."""
        super().__init__()
        self.network = network
        self.register_buffer("memory", memory)

    def forward(self, images: Tensor) -> Tensor:
        """Return the maps of ``images`` ``[n, 3, height, width]``."""
        predicted: Tensor = self.network.predict(self.network.encode(images), self.memory)
        return predicted


def whole(network: CrossReferenceNetwork, photographs: Tensor) -> Whole:
    """Return a network's pass with the photographs encoded."""
    with torch.inference_mode():
        memory = network.memory(network.encode(photographs).flatten(1, 2))
    return Whole(network, memory.reshape(1, -1, memory.shape[-1]).clone()).eval()


def ways(network: CrossReferenceNetwork, photographs: Tensor, example: Tensor) -> dict[str, Pass]:
    """Return all ways that are installed, the suite's own first."""
    merged = network.with_backbone(fused(network.backbone)).eval()
    own, plain = whole(merged, photographs), whole(network.eval(), photographs)
    half = whole(network.with_backbone(fused(network.backbone)).bfloat16().eval(), photographs)
    last = torch.channels_last
    found: dict[str, Pass] = {
        "own": lambda images: own(images.contiguous(memory_format=last)),
        "channels first": own,
        "batch norms apart": lambda images: plain(images.contiguous(memory_format=last)),
        "bfloat16": lambda images: half(images.contiguous(memory_format=last)).float(),
    }
    compiled = torch.compile(own)
    found["torch.compile"] = lambda images: compiled(images.contiguous(memory_format=last))
    if importlib.util.find_spec("onnxruntime") and importlib.util.find_spec("onnxscript"):
        found["ONNX Runtime"] = _onnx(own, example)
    if importlib.util.find_spec("openvino"):
        found["OpenVINO"] = _openvino(own, example)
    return found


def _onnx(module: Whole, example: Tensor) -> Pass:
    import onnxruntime

    written = io.BytesIO()
    program = torch.onnx.export(module, (example,), dynamo=True, verbose=False)
    assert program is not None
    program.save(written)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(written.getvalue(), options, providers=["CPUExecutionProvider"])
    (told,) = session.get_inputs()
    return lambda images: torch.from_numpy(session.run(None, {told.name: images.numpy()})[0])


def _openvino(module: Whole, example: Tensor) -> Pass:
    import openvino

    core = openvino.Core()
    options = {"INFERENCE_NUM_THREADS": 1, "INFERENCE_PRECISION_HINT": "f32"}
    compiled = core.compile_model(openvino.convert_model(module, example_input=example), "CPU", options)
    return lambda images: torch.from_numpy(np.array(compiled(images.numpy())[0]))


def seconds(work: Pass, images: Tensor) -> float:
    """Return the CPU time of one call."""
    start = time.process_time()
    work(images)
    return time.process_time() - start


def measure(scorer: str, height: int, width: int, batch: int, repeats: int) -> None:
    """Print the rows of one network at one image size."""
    settings = ScorerSettings.model_validate({"network": {"backbone": BACKBONE_OF[scorer]}})
    generator = torch.Generator().manual_seed(0)
    images = torch.rand(batch, 3, height, width, generator=generator)
    photographs = torch.rand(REFERENCES, 3, height, width, generator=generator)
    with torch.inference_mode():
        found = ways(build_network(settings.network, 0), photographs, images)
        expected = found["own"](images)
        errors = {name: float((work(images) - expected).abs().max()) for name, work in found.items()}
        rounds = [{name: seconds(work, images) for name, work in found.items()} for _ in range(repeats)]
    own = 1e3 * float(np.median([each["own"] for each in rounds])) / batch
    print(f"{scorer}, {width}x{height}, batches of {batch}: own {own:.1f} ms a candidate")
    for name in list(found)[1:]:
        ratios = [each[name] / each["own"] for each in rounds]
        spread = f"[{min(ratios):.2f} to {max(ratios):.2f}]"
        print(f"    {name:18} {np.median(ratios):.2f} {spread}, differs by {errors[name]:.0e}", flush=True)


def main() -> None:
    """Measure the networks and sizes that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scorers", nargs="+", default=["lite0", "repvit"], choices=BACKBONE_OF)
    parser.add_argument("--sizes", nargs="+", default=["176x117", "480x320"], help="width x height of a candidate")
    parser.add_argument("--batch", type=int, default=8)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    torch.set_num_threads(1)
    for scorer in options.scorers:
        for size in options.sizes:
            width, height = map(int, size.split("x"))
            measure(scorer, height, width, options.batch, options.repeats)


if __name__ == "__main__":
    main()

"""The network against an independent twin in float64 numpy, and its symmetries."""

import numpy as np
import pytest
import torch

from avs.iqa.cross_reference.backbones import fused
from avs.iqa.cross_reference.network import DecoderLayer, build_network
from avs.iqa.cross_reference.position_codes import PositionCodes
from avs.iqa.cross_reference.scorer_settings import RepViTSettings
from tests.tolerances import FLOAT32_NETWORK


def _pictures(count, height, width, seed=0):
    return torch.rand(count, 3, height, width, generator=torch.Generator().manual_seed(seed))


def _interpolated(grid, rows, columns, align_corners):
    """Bilinear interpolation of ``[channels, h, w]``, separably, by its definition."""

    def weights(size, target):
        matrix = np.zeros((target, size))
        for i in range(target):
            if align_corners:
                x = i * (size - 1) / (target - 1) if target > 1 else 0.0
            else:
                x = min(max((i + 0.5) * size / target - 0.5, 0.0), size - 1)
            low = min(int(np.floor(x)), size - 1)
            high = min(low + 1, size - 1)
            matrix[i, low] += 1 - (x - low)
            matrix[i, high] += x - low
        return matrix

    return np.einsum("rh,chw,sw->crs", weights(grid.shape[1], rows), grid, weights(grid.shape[2], columns))


class _Twin:
    """Everything behind the backbone, as formulas."""

    def __init__(self, network):
        self.network = network
        self.state = {key: value.double().numpy() for key, value in network.state_dict().items()}

    def encode(self, images):
        rows, columns = images.shape[-2] // 14, images.shape[-1] // 14
        mean = torch.tensor([0.485, 0.456, 0.406]).view(1, 3, 1, 1)
        deviation = torch.tensor([0.229, 0.224, 0.225]).view(1, 3, 1, 1)
        with torch.inference_mode():
            maps = [features.double().numpy() for features in self.network.backbone((images - mean) / deviation)]
        tokens = []
        for image in range(len(images)):
            total = _interpolated(self.state["positions.codes"][0], rows, columns, align_corners=True)
            for number, features in enumerate(maps):
                # in the paper's order: project, resize, add
                projected = np.einsum("oc,chw->ohw", self.state[f"projections.{number}.weight"], features[image])
                projected += self.state[f"projections.{number}.bias"][:, None, None]
                total = total + _interpolated(projected, rows, columns, align_corners=False)
            tokens.append(total.transpose(1, 2, 0).reshape(rows * columns, -1))
        return tokens

    def predict(self, query, references, rows, columns):
        x = query
        memory = np.concatenate(references)
        for layer in range(2):
            name = f"decoder.{layer}"
            x = self._norm(x + self._attention(x, x, f"{name}.self_attention"), f"{name}.norms.0")
            x = self._norm(x + self._attention(x, memory, f"{name}.cross_attention"), f"{name}.norms.1")
            hidden = np.maximum(self._linear(x, f"{name}.feed_forward.0"), 0)
            x = self._norm(x + self._linear(hidden, f"{name}.feed_forward.2"), f"{name}.norms.2")
        hidden = self._linear(x, "head.0")
        hidden = np.where(hidden > 0, hidden, 0.01 * hidden)
        values = 1 / (1 + np.exp(-self._linear(hidden, "head.2")))
        pixels = np.empty((rows * 14, columns * 14))
        for token, patch in enumerate(values):
            row, column = divmod(token, columns)
            pixels[row * 14 : row * 14 + 14, column * 14 : column * 14 + 14] = patch.reshape(14, 14)
        return pixels

    def _linear(self, x, name):
        return x @ self.state[f"{name}.weight"].T + self.state[f"{name}.bias"]

    def _norm(self, x, name):
        centred = x - x.mean(axis=1, keepdims=True)
        scaled = centred / np.sqrt((centred**2).mean(axis=1, keepdims=True) + 1e-5)
        return scaled * self.state[f"{name}.weight"] + self.state[f"{name}.bias"]

    def _attention(self, x, memory, name, heads=8):
        weight, bias = self.state[f"{name}.in_proj_weight"], self.state[f"{name}.in_proj_bias"]
        width = x.shape[1]
        query, key, value = (
            source @ weight[i * width : (i + 1) * width].T + bias[i * width : (i + 1) * width]
            for i, source in enumerate((x, memory, memory))
        )
        out = np.empty_like(query)
        for head in range(heads):
            part = slice(head * width // heads, (head + 1) * width // heads)
            logits = query[:, part] @ key[:, part].T / np.sqrt(width // heads)
            exponentials = np.exp(logits - logits.max(axis=1, keepdims=True))
            out[:, part] = exponentials / exponentials.sum(axis=1, keepdims=True) @ value[:, part]
        return self._linear(out, f"{name}.out_proj")


@pytest.mark.parametrize(("height", "width"), [(56, 84), (45, 31)])
def test_prediction_equals_the_twin(network, height, width):
    images = _pictures(3, height, width)
    with torch.inference_mode():
        tokens = network.encode(images)
        predicted = network.predict(tokens[:1], network.memory(tokens[1:].reshape(1, -1, 256)))[0].numpy()
    twin = _Twin(network)
    query, *references = twin.encode(images)
    expected = twin.predict(query, references, height // 14, width // 14)
    np.testing.assert_allclose(tokens[0].reshape(-1, 256).numpy(), query, atol=FLOAT32_NETWORK)
    np.testing.assert_allclose(predicted, expected, atol=FLOAT32_NETWORK)


@pytest.mark.parametrize(("height", "width", "rows", "columns"), [(345, 518, 24, 37), (27, 14, 1, 1), (98, 99, 7, 7)])
def test_map_covers_whole_tokens(network, height, width, rows, columns):
    with torch.inference_mode():
        tokens = network.encode(_pictures(1, height, width))
        values = network.predict(tokens, network.memory(tokens.flatten(1, 2)))
    assert tokens.shape == (1, rows, columns, 256)
    assert values.shape == (1, rows * 14, columns * 14)
    assert 0 <= float(values.min()) <= float(values.max()) <= 1


def test_image_smaller_than_a_token_is_refused(network):
    with pytest.raises(ValueError, match="smaller than a token"):
        network.encode(torch.zeros(1, 3, 13, 40))


def test_order_of_references_does_not_matter(network):
    with torch.inference_mode():
        query, *references = network.encode(_pictures(4, 42, 56)).flatten(1, 2).unsqueeze(1)
        grid = query.view(1, 3, 4, 256)
        first = network.predict(grid, network.memory(torch.cat(references, dim=1)))
        second = network.predict(grid, network.memory(torch.cat(references[::-1], dim=1)))
    torch.testing.assert_close(first, second, rtol=0, atol=FLOAT32_NETWORK)


def test_absent_tokens_do_not_count(network):
    with torch.inference_mode():
        query, first, second = network.encode(_pictures(3, 42, 56)).flatten(1, 2).unsqueeze(1)
        grid = query.view(1, 3, 4, 256)
        first, second = network.memory(first), network.memory(second)
        alone = network.predict(grid, first)
        absent = torch.zeros(1, 24, dtype=torch.bool)
        absent[:, 12:] = True
        masked = network.predict(grid, torch.cat([first, second], dim=1), absent)
        both = network.predict(grid, torch.cat([first, second], dim=1))
    torch.testing.assert_close(masked, alone, rtol=0, atol=FLOAT32_NETWORK)
    assert float((both - alone).abs().max()) > FLOAT32_NETWORK


def test_images_of_one_set_share_their_references(network):
    with torch.inference_mode():
        tokens = network.encode(_pictures(6, 42, 56))
        queries, memory = tokens[:4], network.memory(tokens[4:].flatten(1, 2))
        absent = torch.zeros(2, 12, dtype=torch.bool)
        absent[1, 7:] = True
        shared = network.predict(queries, memory, absent)
        repeated = network.predict(queries, memory.repeat_interleave(2, dim=0), absent.repeat_interleave(2, dim=0))
    torch.testing.assert_close(shared, repeated, rtol=0, atol=FLOAT32_NETWORK)


def test_decoder_layer_is_that_of_torch():
    torch.manual_seed(0)
    own, other = (
        DecoderLayer(32, 4, 48).eval(),
        torch.nn.TransformerDecoderLayer(32, 4, 48, 0.0, batch_first=True).eval(),
    )
    names = {
        "self_attention": "self_attn",
        "cross_attention": "multihead_attn",
        "feed_forward.0": "linear1",
        "feed_forward.2": "linear2",
        **{f"norms.{i}": f"norm{i + 1}" for i in range(3)},
    }
    other.load_state_dict(
        {
            names[part] + key.removeprefix(part): value
            for key, value in own.state_dict().items()
            for part in names
            if key.startswith(part)
        }
    )
    x, memory = torch.randn(2, 5, 32), torch.randn(2, 9, 32)
    absent = torch.tensor([[False] * 9, [False] * 6 + [True] * 3])
    torch.testing.assert_close(own(x, own.memory(memory), absent), other(x, memory, memory_key_padding_mask=absent))


def test_fused_network_predicts_the_same(network):
    merged = network.with_backbone(fused(network.backbone))
    images = _pictures(2, 56, 70)
    with torch.inference_mode():
        predictions = []
        for each in (network, merged):
            tokens = each.encode(images)
            predictions.append(each.predict(tokens[:1], each.memory(tokens[1:].flatten(1, 2))))
    torch.testing.assert_close(predictions[0], predictions[1], rtol=0, atol=FLOAT32_NETWORK)


def test_position_codes_are_fixed_and_stored():
    first, second = PositionCodes(16, 40, seed=5), PositionCodes(16, 40, seed=5)
    assert torch.equal(first.codes, second.codes)
    assert not torch.equal(first.codes, PositionCodes(16, 40, seed=6).codes)
    assert "codes" in first.state_dict()
    assert not list(first.parameters())
    assert torch.equal(first(40, 40), first.codes)
    corners = first(7, 9)[..., [0, 0, -1, -1], [0, -1, 0, -1]]
    torch.testing.assert_close(corners, first.codes[..., [0, 0, -1, -1], [0, -1, 0, -1]])


def test_weights_depend_on_the_seed_alone():
    torch.manual_seed(9)
    before = torch.get_rng_state()
    first = build_network(RepViTSettings(), seed=1).state_dict()
    assert torch.equal(torch.get_rng_state(), before)
    torch.manual_seed(10)
    second = build_network(RepViTSettings(), seed=1).state_dict()
    assert all(torch.equal(first[key], second[key]) for key in first)
    layers = [first[f"decoder.{i}.feed_forward.0.weight"] for i in range(2)]
    assert not torch.equal(*layers)

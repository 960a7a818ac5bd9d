"""Stand-ins for four networks by their public signatures: each sees a plane, in a frame of its own.

The plane z = 0 of the world lies before a ring of cameras. A stand-in computes the point of each pixel from the cameras
that the test knows, moves all into another frame, and gives them in the form in which the real network does.
"""

import sys
import types

import numpy as np
import torch
from PIL import Image

SCALE, SHIFT = 0.25, np.array([3.0, -1.0, 2.0])


def world_points(cameras, size):
    """Return the points ``[n, h, w, 3]`` of the plane z = 0 at the pixels of pictures of ``size``, and their depths."""
    width, height = size
    cameras = cameras.resized(np.tile([[width, height]], (len(cameras), 1)))
    columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    pixels = np.stack([columns, rows, np.ones_like(rows)], axis=-1)
    points, depths = [], []
    for row in range(len(cameras)):
        pose = np.linalg.inv(cameras.world_to_camera[row])
        rays = pixels @ np.linalg.inv(cameras.intrinsics[row]).T
        depth = -pose[2, 3] / (rays @ pose[:3, :3].T)[..., 2]
        points.append((rays * depth[..., None]) @ pose[:3, :3].T + pose[:3, 3])
        depths.append(depth)
    return np.stack(points), np.stack(depths), cameras


def own_frame(points):
    return points * SCALE + SHIFT


def own_poses(cameras):
    poses = np.linalg.inv(cameras.world_to_camera)
    poses[:, :3, 3] = own_frame(poses[:, :3, 3])
    return poses


class _Model:
    def __init__(self, cameras):
        self.cameras = cameras

    def to(self, device):
        return self

    def eval(self):
        return self


def _class(cameras, methods, seen):
    def from_pretrained(path):
        seen["weights"] = path
        return type("Model", (_Model,), methods)(cameras)

    return types.SimpleNamespace(from_pretrained=from_pretrained)


def _install(monkeypatch, **contents):
    for name, content in contents.items():
        name = name.replace("__", ".")
        parts = name.split(".")
        for end in range(1, len(parts) + 1):
            parent = ".".join(parts[:end])
            if parent not in sys.modules or end == len(parts):
                module = types.ModuleType(parent)
                module.__path__ = []
                module.__spec__ = types.SimpleNamespace(name=parent)
                monkeypatch.setitem(sys.modules, parent, module)
        vars(sys.modules[name]).update(content)


def install_mast3r(monkeypatch, cameras):
    seen = {}

    def load_images(paths, size, verbose=True):
        assert all(Image.open(path).mode == "RGB" for path in paths)
        seen["side"] = size
        return [{"idx": number} for number in range(len(paths))]

    def make_pairs(images, scene_graph="complete", prefilter=None, symmetrize=True):
        return [(a, b) for a in images for b in images if a is not b]

    def sparse_global_alignment(imgs, pairs_in, cache_path, model, device="cuda", shared_intrinsics=False, **others):
        assert set(others) == {"lr1", "niter1", "lr2", "niter2", "opt_depth", "matching_conf_thr"}
        seen["pairs"] = len(pairs_in)
        points, depths, _ = world_points(model.cameras, (24, 16))
        confidence = torch.full(depths.shape, 3.0)
        confidence[:, 0] = 1.0  # the first row of pixels is unsure
        return types.SimpleNamespace(
            imgs=[np.full((16, 24, 3), 0.5)] * len(imgs),
            get_im_poses=lambda: torch.from_numpy(own_poses(model.cameras)),
            get_dense_pts3d=lambda clean_depth=True: (
                [torch.from_numpy(own_frame(one).reshape(-1, 3)) for one in points],
                [torch.from_numpy(one.reshape(-1)) for one in depths],
                list(confidence),
            ),
        )

    _install(
        monkeypatch,
        mast3r__utils__path_to_dust3r={},
        mast3r__cloud_opt__sparse_ga={"sparse_global_alignment": sparse_global_alignment},
        mast3r__image_pairs={"make_pairs": make_pairs},
        mast3r__model={"AsymmetricMASt3R": _class(cameras, {}, seen)},
        dust3r__utils__image={"load_images": load_images},
    )
    return seen


def install_vggt(monkeypatch, cameras):
    seen = {}

    def call(self, images):
        assert images.shape == (len(self.cameras), 3, 16, 24)
        _, depths, _ = world_points(self.cameras, (24, 16))
        confidence = torch.full(depths.shape, 3.0)
        confidence[:, 0] = 1.0
        return {
            "pose_enc": "encoded",
            "depth": torch.from_numpy(depths)[None, ..., None],
            "depth_conf": confidence[None],
        }

    def decode(encoded, size):
        assert (encoded, tuple(size)) == ("encoded", (16, 24))
        transforms = np.linalg.inv(own_poses(cameras))[None, :, :3]
        return torch.from_numpy(transforms), torch.from_numpy(cameras.intrinsics)[None]

    def unproject(depth, extrinsics, intrinsics):
        assert depth.shape == (len(cameras), 16, 24, 1)
        assert extrinsics.shape == (len(cameras), 3, 4)
        return own_frame(world_points(cameras, (24, 16))[0])

    def load(paths):
        pictures = [np.asarray(Image.open(path)) for path in paths]
        return torch.from_numpy(np.stack(pictures)).permute(0, 3, 1, 2).float() / 255

    _install(
        monkeypatch,
        vggt__models__vggt={"VGGT": _class(cameras, {"__call__": call}, seen)},
        vggt__utils__load_fn={"load_and_preprocess_images": load},
        vggt__utils__pose_enc={"pose_encoding_to_extri_intri": decode},
        vggt__utils__geometry={"unproject_depth_map_to_point_map": unproject},
    )
    return seen


def install_mapanything(monkeypatch, cameras):
    seen = {}

    def infer(
        self, views, memory_efficient_inference, use_amp, amp_dtype, apply_mask, mask_edges, apply_confidence_mask
    ):
        seen["views"] = views
        points, _, _ = world_points(self.cameras, (24, 16))
        mask = torch.ones(1, 16, 24, 1, dtype=torch.bool)
        mask[:, 0] = False
        return [
            {
                "pts3d": torch.from_numpy(own_frame(one))[None],
                "conf": torch.ones(1, 16, 24),
                "mask": mask,
                "img_no_norm": torch.full((1, 16, 24, 3), 0.5),
                "camera_poses": torch.from_numpy(pose)[None],
            }
            for one, pose in zip(points, own_poses(self.cameras), strict=True)
        ]

    _install(
        monkeypatch,
        mapanything__models={"MapAnything": _class(cameras, {"infer": infer}, seen)},
        mapanything__utils__image={"preprocess_inputs": lambda views: views},
    )
    return seen


def install_da3(monkeypatch, cameras):
    seen = {}

    def inference(self, image, extrinsics=None, intrinsics=None, align_to_input_ext_scale=True, process_res=504):
        seen.update(extrinsics=extrinsics, intrinsics=intrinsics, side=process_res)
        _, depths, smaller = world_points(self.cameras, (24, 16))
        matrices = smaller.intrinsics.copy()
        matrices[:, :2, 2] -= 0.5  # its pixels count from the middle of the first one
        confidence = np.full(depths.shape, 3.0, dtype=np.float32)
        confidence[:, 0] = 0.5
        return types.SimpleNamespace(
            depth=depths * SCALE,
            conf=confidence,
            extrinsics=np.linalg.inv(own_poses(self.cameras))[:, :3],
            intrinsics=matrices,
            processed_images=np.full((len(image), 16, 24, 3), 128, dtype=np.uint8),
        )

    _install(monkeypatch, depth_anything_3__api={"DepthAnything3": _class(cameras, {"inference": inference}, seen)})
    return seen

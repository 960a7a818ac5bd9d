"""The sphere, with the back end that sees it as it is."""

import pytest

from avs.coverage import clouds_of_views
from avs.coverage.reference_cloud import write_reference
from tests.scene_coverage.sphere_scene import perfect, reference_job, write_sphere


@pytest.fixture
def sphere(tmp_path, monkeypatch):
    scene = write_sphere(tmp_path / "ball")
    monkeypatch.setattr(clouds_of_views, "reconstruct", perfect(scene))
    return scene


@pytest.fixture
def reference(sphere, tmp_path):
    write_reference(sphere.folder, reference_job(), tmp_path / "reference")
    return tmp_path / "reference"

"""What tests of readers have in common: the scene that a reader prepares, and a fault that is one line."""

import re

import pytest

from avs.scene.scene import read_scene
from avs.system.errors import UserError
from avs.system.files import explained


def first_scene(reader, tmp_path, dataset="mine"):
    """Prepare the first scene of a reader below ``tmp_path`` and read it."""
    (name, settings), *_ = reader.scenes().items()
    with explained():
        settings.prepare(dataset, tmp_path / "out" / name)
    return read_scene(tmp_path / "out" / name)


def assert_refused(prepare, message, tmp_path):
    """See that ``prepare`` fails with one line that ``message`` matches, and leaves nothing of a scene."""
    with pytest.raises(UserError) as caught:
        prepare()
    assert re.search(message, str(caught.value)), str(caught.value)
    assert str(caught.value).isprintable()
    assert not list((tmp_path / "out").glob("*"))

"""The small network and the toy distortion data of the scorers' tests."""

from tests.iqa.cross_reference.conftest import network, toys

__all__ = ["network", "toys"]

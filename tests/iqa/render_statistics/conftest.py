"""The toy distortion data of the scorers' tests."""

from tests.iqa.cross_reference.conftest import toys

__all__ = ["toys"]

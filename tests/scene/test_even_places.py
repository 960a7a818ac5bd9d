import pytest

from avs.scene.even_places import evenly_spread


@pytest.mark.parametrize(
    ("count", "wanted", "expected"),
    [(10, 3, [0, 4, 9]), (3, 9, [0, 1, 2]), (5, 1, [0]), (5, 0, []), (0, 4, []), (2, 2, [0, 1])],
)
def test_places_are_spread_with_both_ends(count, wanted, expected):
    assert evenly_spread(count, wanted) == expected
